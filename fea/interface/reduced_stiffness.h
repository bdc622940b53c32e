// The link as one element between all its interfaces.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/interface/coupling.h"

namespace kinetostat::fea {

/// Stiffness of the free link, 6(m + 1) square, from the 6m x 6m flexibility of its m loaded
/// interfaces against the first (LinkResponse): wrenches [force; moment] on all interfaces, in the
/// order of `interfaces` and at their points, per motion [translation; rotation] of all. Symmetric;
/// the six rigid motions are its null space, by construction. Throws std::domain_error when the
/// flexibility is not positive definite.
Eigen::MatrixXd reduced_stiffness(const Eigen::MatrixXd& flexibility,
                                  const std::vector<CoupledInterface>& interfaces);

}  // namespace kinetostat::fea
