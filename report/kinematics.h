// A kinematic calibration, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/calibration/kinematics/kinematic_calibration.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Units in which errors of a geometry are read: the campaign's, mm for m, mrad for rad, ppm of a
/// ratio.
struct SmallUnits {
  std::string length, angle;

  explicit SmallUnits(const spatial::UnitSystem& units);
  std::string of(const calibration::GeometricParameter& what) const {
    return what.unit().empty() ? "ppm" : what.turns() ? angle : length;
  }
  double length_in(double metres) const;
  double angle_in(double radians) const;
  double in(const calibration::GeometricParameter& what, double si) const {
    return what.unit().empty() ? 1e6 * si : what.turns() ? angle_in(si) : length_in(si);
  }
};

/// "well conditioned": what a condition number of columns scaled by tolerances means (below 100 as
/// Schröer, Albright and Grethlein recommend, Robotics and Computer-Integrated Manufacturing 1997).
std::string conditioning_in_words(double condition);
/// "the kinematics leave it redundant".
std::string in_words(calibration::LeftOut why);

/// Every parameter with its deviation, all that was left out with the reason, correlations, indices
/// of observability.
std::string text(const calibration::Campaign& campaign,
                 const calibration::KinematicCalibration& calibration);
/// Every figure, SI.
io::Json to_json(const calibration::Campaign& campaign,
                 const calibration::KinematicCalibration& calibration);

}  // namespace kinetostat::report
