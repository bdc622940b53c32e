// Joints that turn and joints that slide have other units.
#pragma once

#include <string>

#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::report {

/// Whether the joint of that name ("rho" or "x.rho") turns: its coordinate is in [rad], else in
/// [m].
bool joint_turns(const vjm::Robot& robot, const std::string& name);

}  // namespace kinetostat::report
