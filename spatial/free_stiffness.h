// The stiffness of a free body from its flexibility with one place held.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::spatial {

/// 6n square, between n places at `points` [m], from the flexibility (6(n - 1) square) of all but
/// `held`, in their order: wrenches [force; moment] per motion [translation; rotation] of all, at
/// their points. Symmetric; the six rigid motions are its null space, by construction. Throws
/// std::domain_error when the flexibility is not positive definite.
Eigen::MatrixXd free_stiffness(const Eigen::MatrixXd& flexibility,
                               const std::vector<Vector3>& points, std::size_t held);

}  // namespace kinetostat::spatial
