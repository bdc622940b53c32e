// Poses about a posture, to see how an index changes there.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/workspace/pose_list.h"

namespace kinetostat::vjm {

struct Neighbourhood {
  PoseList list;
  /// The joints that were moved, "chain.joint"; none where the platform was.
  std::vector<std::string> joints;
};

/// The platform 3 x 3 x 3 times, moved by `distance` [m] to either side along the base axes and
/// turned as it is. Where some of these poses are out of reach (an arm of three joints cannot hold
/// its orientation, a stretched one goes no further), the three actuated joints that move the
/// platform most are moved instead, each to either side by as much as takes the platform
/// `distance` away, at the most 30 degrees and within the joint's range; all combinations.
Neighbourhood neighbourhood(const Manipulator& manipulator, const Posture& posture,
                            double distance);

}  // namespace kinetostat::vjm
