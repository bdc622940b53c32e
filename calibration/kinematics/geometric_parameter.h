// Errors of a robot's geometry as unknowns of a fit.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/regression/parameter.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// What an error of the geometry is in the hands of those who correct it, in the order in which the
/// first of several that cannot be distinguished is kept.
enum class GeometryGroup { base, tool, joint_offset, link, drive };
/// "base", "tool", "joint offset", "link", "drive".
std::string to_string(GeometryGroup group);

/// One component of the constant displacement E behind a place of a chain (effect
/// `geometric_error`): the frame there is moved by [x, y, z] and turned by the rotation vector
/// [rx, ry, rz], both in its axes,
///
///   T(q) = E_base  D_1(q_1) E_1  D_2(q_2) E_2 ...  D_n(q_n) E_n  ...  E_end
///
/// D_i(q_i): from the frame behind joint i-1 to that behind joint i. The component of E_i along the
/// axis of an actuated joint i is the offset of that joint. One such displacement between
/// successive joints describes every error of the constant geometry between them (completeness:
/// Everett, Driels and Mooring, IEEE Int. Conf. Robotics and Automation 1987); they are more than
/// there are independent ones.
///
/// Of a drive that slides, the ratio by which it leads its joint too far (effect
/// `transmission_ratio`): the lead of a screw, the pitch of a scale. Gears have none, their teeth
/// are counted.
struct GeometricParameter {
  GeometryGroup group = GeometryGroup::link;
  std::string at;              // place of the effect: "arm.q1", "arm.base", "arm.end"
  std::string place;           // as people call it: "q1", or "x.q1" where there are several chains
  std::size_t effect = 0;      // in GeometricModel::effects
  Eigen::Index component = 0;  // of the displacement; 0 of a drive
  /// Standard tolerance [m, rad or 1]: what a parameter that readings know no better is not worth.
  double tolerance = 0;

  bool turns() const { return group != GeometryGroup::drive && component >= 3; }
  /// "m", "rad"; empty for a ratio.
  std::string unit() const;
  char axis() const { return "xyz"[component % 3]; }
  /// "the offset of q1", "the shift behind q2 along x", "the turn of the base about z", "the scale
  /// of q3".
  std::string phrase() const;
};

/// Standard tolerances of lengths [m] and angles [rad].
struct Tolerance {
  double length = 0, angle = 0;

  /// Of a ratio: the length over a metre.
  double ratio() const { return length; }
};

/// A robot with an error of unknown size at each place that can have one.
struct GeometricModel {
  /// The robot's own, then a `geometric_error` with all components 0 at each place without one and
  /// a `transmission_ratio` of 0 at each sliding drive without one.
  std::vector<vjm::Effect> effects;
  /// In the order of the groups, in each from base to end: where one of several that cannot be
  /// distinguished is kept, it is the first.
  std::vector<GeometricParameter> parameters;
};

/// Places: base and end of every chain, and behind each of its joints. The free motion of a passive
/// joint takes up any error along it, which is therefore none.
GeometricModel geometric_model(const vjm::Robot& robot, const Tolerance& tolerance);

/// The same as unknowns of a fit, in their order: each starts where the effect stands.
std::vector<Parameter> fit_parameters(const GeometricModel& model, const vjm::Manipulator& bare);

}  // namespace kinetostat::calibration
