// Nominal postures: from a target pose (inverse kinematics), or from joint coordinates.
#pragma once

#include <map>
#include <string>

#include "kinetostat/vjm/manipulator/posture_result.h"

namespace kinetostat::vjm {

/// Both work on the nominal manipulator, without geometric errors.
///
/// Actuated and passive coordinates that bring every chain to `target` with relaxed links, by
/// damped least squares from the home values (so that the branch nearest to them is found), then
/// from scattered starts. A redundant chain takes the solution nearest to its start.
PostureResult posture_at(const Manipulator& manipulator, const spatial::Pose& target,
                         const PostureOptions& options = {});

/// The same with joints that keep values [m or rad], named as below: the others alone lead to
/// `target`. Starts with the posture of posture_at(), from which the joints go to their values in
/// steps that the others follow, so that neighbouring values have neighbouring postures as far as
/// the self-motion leads; only where it ends before, with the starts of posture_at(). The values
/// are kept to the bit. Throws std::invalid_argument for a name as below.
PostureResult posture_holding(const Manipulator& manipulator, const spatial::Pose& target,
                              const std::map<std::string, double>& held,
                              const PostureOptions& options = {});

/// The posture for given actuated coordinates [m or rad] by "chain.joint" (or "joint" where the
/// name is unique): forward kinematics of a serial chain; for parallel ones passive joints and
/// platform are solved for together, in the assembly that home leads to. Passive coordinates may be
/// given too, as starting values (as exact values in a serial manipulator). Actuated joints that
/// are not named keep their home values. Throws std::invalid_argument for an unknown name (with
/// did-you-mean) or an ambiguous one.
PostureResult posture_from_joints(const Manipulator& manipulator,
                                  const std::map<std::string, double>& coordinates,
                                  const PostureOptions& options = {});

}  // namespace kinetostat::vjm
