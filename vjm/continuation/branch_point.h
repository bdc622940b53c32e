// Classification of a critical point as bifurcation or limit point, and the directions in which
// branches leave it. Internal to this module.
//
// Along a path the derivative D = [dr/dy dr/dp], n x (n + 1), has one null vector, the tangent. At
// a limit point that is all; where branches meet, D has the tangents of all of them (H. B. Keller,
// 1977). This also holds where the loops of the chains degenerate, so that eigenvalues of the
// energy say nothing.
#pragma once

#include <vector>

#include "kinetostat/vjm/continuation/continuation.h"

namespace kinetostat::vjm {

/// Null vectors of D beside the tangent: motions that cost nothing, reactions that are
/// indeterminate. A path has those that all its stations have in common.
int idle_directions(Continuation& continuation, const Station& station);

/// How far D is from losing rank at a station: its smallest singular value beside the idle ones.
double distance_to_branch_point(Continuation& continuation, const Station& station, int idle);

/// Unit vectors that complete, with what D has at a station beside it on the path, the null space
/// of D at a branch point: `count` of them, orthogonal to the path.
std::vector<Eigen::VectorXd> leaving_directions(Continuation& continuation, const Station& beside,
                                                const Station& at, int idle, int count);

}  // namespace kinetostat::vjm
