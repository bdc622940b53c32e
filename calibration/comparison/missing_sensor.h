// The sensor that would determine what the readings of a campaign leave open.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// A sensor beside those of a campaign, and what it would do under the same loads.
struct MissingSensor {
  bool tilt = false;              // else the position of a point
  std::string place;              // as a campaign file names it
  std::vector<std::string> open;  // what it would determine, "the stiffness of 'q2'"
  double with = 0;                // largest standard deviation then, of a change worth knowing

  std::string kind_in_words() const;  // "tilt sensor"
  /// "a tilt sensor on 'arm.base', read under the same loads: it would determine ..."
  std::string phrase() const;
};

/// Of a tilt sensor about both horizontal axes and a sensor of position, at every place of the
/// robot, the one that leaves the least of the worst standard deviation: the diagonal of
///
///   (J'J + D'D + I / w^2)^-1
///
/// with the derivatives J of the readings in units of the noise and D of what the sensor reads in
/// units of a usual noise of 5 urad, or 5 um, by `parameters` at their starts, and w = 10 what is
/// known of them before. Nothing for a campaign that reads the platform alone, where the readings
/// determine them to a fifth by themselves, where no noise is known, or where no sensor does a
/// tenth of that.
std::optional<MissingSensor> missing_sensor(const vjm::Robot& robot,
                                            const std::vector<vjm::Effect>& effects,
                                            const std::vector<Parameter>& parameters,
                                            const Campaign& campaign, const Noise& noise,
                                            int threads, common::Progress& progress);

}  // namespace kinetostat::calibration
