// A serial robot for MuJoCo.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::vjm {

struct MjcfExport {
  std::string text;               // of the XML file
  std::vector<std::string> lost;  // what the format cannot hold, or was left out, in words
};

/// MuJoCo's XML (MJCF), SI units: a body for every joint that moves, with the masses behind it
/// (particles.h) as mass, centre and inertia; the spring of a drive or passive joint as the
/// stiffness of its joint, relaxed at the command of `posture` or at rest; drives without a spring
/// fixed at their command; a site "tool" at the reference point; gravity; `posture` as keyframe.
/// Links are rigid: MuJoCo has no springs of six directions. Bodies get an inertia of a billionth
/// more, because MuJoCo asks for some about every axis. Throws std::invalid_argument for a robot of
/// several chains, and for joints that share a coordinate.
MjcfExport mjcf(const Robot& robot, const Posture& posture);

}  // namespace kinetostat::vjm
