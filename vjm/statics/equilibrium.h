// Static equilibrium of a loaded manipulator: platform pose given, or load given.
#pragma once

#include <vector>

#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/statics/equilibrium_result.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

/// Moves the platform to `pose` and finds the wrench that holds it there (MMT11 eq. 5-10, solved by
/// Newton's method with the exact Hessian instead of the paper's fixed point), gravity and the
/// loads at nodes acting. On failure the state is the last equilibrium found on the way, `reached`
/// says how far that is.
Equilibrium equilibrium_at_pose(const Manipulator& manipulator, const Posture& posture,
                                const spatial::Pose& pose, const EquilibriumOptions& options = {},
                                const std::vector<NodeLoad>& node_loads = {});

/// Finds the pose that the platform takes under dead loads and gravity (MMT11 eq. 11, NONPERF eq.
/// 21).
Equilibrium equilibrium_under_load(const Manipulator& manipulator, const Posture& posture,
                                   const Load& load, const EquilibriumOptions& options = {});

}  // namespace kinetostat::vjm
