// `sensors:`, `displacement_control:`, `weights:`, `cylinders:` and `torques:` of a campaign file.
// Internal to this module.
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

/// `displacement_control:`, if it is there: adds to `campaign` what is set and the component of the
/// force that is read, to `sigma` its standard deviation. Returns which of fx ... mz that is.
/// Throws common::InputError.
std::size_t read_control(const io::YamlNode& top, Campaign& campaign, Eigen::VectorXd& sigma);

/// Torques that act in its joints. Throws common::InputError.
std::vector<Torque> read_torques(const io::YamlNode& top, const vjm::Manipulator& manipulator,
                                 const Campaign& campaign);

}  // namespace kinetostat::calibration
