// Files that describe robots, in any of the formats.
#pragma once

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// By the extension and the content: URDF, SDF, MJCF, or a table of Denavit and Hartenberg's
/// parameters (YAML, CSV). Throws common::InputError with file and line when the file is none of
/// these, or as the reader of its format does.
RobotDescription read_robot_description(const std::filesystem::path& file);

}  // namespace kinetostat::vjm
