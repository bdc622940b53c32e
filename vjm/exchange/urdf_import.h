// Robots described in URDF.
#pragma once

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// With the springs of joints that Gazebo's extension gives (springStiffness). Throws
/// common::InputError with file and line when the file is not XML, not URDF (a xacro file that was
/// not expanded), names a link or joint twice or one that is not there, or has a joint of a type
/// that a stiffness model cannot have (floating, planar).
RobotDescription read_urdf(const std::filesystem::path& file);

}  // namespace kinetostat::vjm
