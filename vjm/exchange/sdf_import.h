// Robots described in SDF, the format of Gazebo.
#pragma once

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// The first model of an SDF file (http://sdformat.org/spec, versions 1.4 to 1.11), in the frame of
/// the model; frames are links that carry nothing. A joint whose frame is not that of its child
/// leads to a link "child@joint" between. Masses are those of <inertial>, with `auto` what the
/// collision shapes weigh, but not those of meshes.
/// Throws common::InputError with file and line when the file is not XML or not SDF, a frame is
/// given in one that is not there, and for joints with more or less than one axis, nested models
/// and includes.
RobotDescription read_sdf(const std::filesystem::path& file);

}  // namespace kinetostat::vjm
