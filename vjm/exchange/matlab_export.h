// A robot in a posture as a script for MATLAB or GNU Octave.
#pragma once

#include <string>

#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::vjm {

/// The equations of small motions about the posture (natural_modes.h) as matrices K, M, D and J: of
/// any robot, elastic links and closed chains among them. D damps every mode with `damping_ratio`.
/// Also `platform`, the reference point, and `frequencies` as the script finds them.
std::string matlab(const Robot& robot, const Posture& posture, double damping_ratio = 0);

/// What such a script does not hold, in words.
std::vector<std::string> lost_in_matlab(const Robot& robot, double damping_ratio = 0);

}  // namespace kinetostat::vjm
