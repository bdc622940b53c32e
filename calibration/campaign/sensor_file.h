// `sensors:`, `weights:` and `cylinders:` of a campaign file. Internal to this module.
#pragma once

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::calibration {

/// Whether `datum_noise: 0` says that no unloaded reading has an error.
bool is_all_exact(const io::YamlNode& datum_noise);

/// Adds the sensors that the file describes to those of `campaign`, behind the platform, with their
/// components, what they watch, and their datum noise; units, displacement and observation of the
/// campaign are set. Returns the standard deviation of each component, NaN where not stated. Throws
/// common::InputError.
Eigen::VectorXd read_sensors(const io::YamlNode& top, const vjm::Manipulator& manipulator,
                             Campaign& campaign);

/// What hangs on the robot; adds to what `campaign` watches. Throws common::InputError.
std::vector<Weight> read_weights(const io::YamlNode& top, const vjm::Manipulator& manipulator,
                                 Campaign& campaign);

/// Cylinders that push and pull on it; adds to what `campaign` watches. Throws common::InputError.
std::vector<Cylinder> read_cylinders(const io::YamlNode& top, const vjm::Manipulator& manipulator,
                                     Campaign& campaign);

}  // namespace kinetostat::calibration
