// Sensors that columns of a table may be of, by their names.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/spatial/units.h"

namespace kinetostat::calibration {

/// What a column may read, as a campaign file would say it.
struct SensorGuess {
  std::string name = {};   // of the sensor: "tilt" of "tilt_x"
  std::string kind;        // "gauge", "tilt", "distance", "joint", "torque"
  char axis = 0;           // 'x' of "tilt_x", 0: not said
  std::string joint = {};  // that is read, empty for other kinds
};

/// The word "dial", "gauge", "tilt", "level", "ballbar", "encoder", "torque" and the like beside
/// numbers, an axis or the name of a joint, without unit: "dial_1", "Tilt X", "theta_A2". `joints`:
/// names of the robot's. nullopt for other names.
std::optional<SensorGuess> sensor_guess(std::string_view column,
                                        const std::vector<std::string>& joints);

}  // namespace kinetostat::calibration
