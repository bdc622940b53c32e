// Which joints may move while the platform stays where it is.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// Whether the joint ("chain.joint", or "joint" where unique) takes part in a self-motion at a pose
/// of the platform in base axes, while the joints in `held` keep their values [m or rad]: whether a
/// posture_holding() it exists a little (1e-3 rad, or 1e-3 of the reach of its chain) to either
/// side of where it stands. By the motion itself and not by its rank, so that a singular posture
/// does not count as freedom. False where the pose is not reached. Throws std::invalid_argument as
/// find_joint() does.
bool may_move_at(const Manipulator& manipulator, const spatial::Pose& target,
                 const std::map<std::string, double>& held, const std::string& joint);

/// The actuated joints of which that is true, by their full names.
std::vector<std::string> redundant_joints(const Manipulator& manipulator,
                                          const spatial::Pose& target,
                                          const std::map<std::string, double>& held);

}  // namespace kinetostat::vjm
