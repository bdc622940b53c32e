// `sensors:` and `weights:` of a campaign file. Internal to this module.
#pragma once

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::calibration {

/// Adds the sensors that the file describes to those of `campaign`, behind the platform, with their
/// components, what they watch, and their datum noise; units, displacement and observation of the
/// campaign are set. Returns the standard deviation of each component, NaN where not stated. Throws
/// common::InputError.
Eigen::VectorXd read_sensors(const io::YamlNode& top, const vjm::Manipulator& manipulator,
                             Campaign& campaign);

/// What hangs on the robot; adds to what `campaign` watches. Throws common::InputError.
std::vector<Weight> read_weights(const io::YamlNode& top, const vjm::Manipulator& manipulator,
                                 Campaign& campaign);

}  // namespace kinetostat::calibration
