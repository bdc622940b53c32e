// How stiff the coordinates of a chain are before anything loads them.
#pragma once

#include <Eigen/Core>

#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

/// Chain::stiffness() with the tangents of the laws at coordinates x, nothing deflected
/// [N/m, N m/rad].
Eigen::MatrixXd relaxed_stiffness(const Chain& chain, const Eigen::VectorXd& x);

}  // namespace kinetostat::vjm
