// Direct kinematics of a chain with exact first and second derivatives.
#pragma once

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/chain.h"

namespace kinetostat::vjm {

using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// What direct kinematics gives at one state; kept between calls so that no memory is allocated.
struct ChainKinematics {
  spatial::Pose end;      // of the end frame, in base axes
  Matrix6X jacobian;      // 6 x coordinates, [v; w] at the end point, base axes
  Matrix6X joint_twists;  // 6 x joints: the same for each elementary joint alone (factor applied)
  double reach = 0;       // largest distance of a joint from the end point [m]
};

/// Position of the end and geometric Jacobian for coordinates x (size chain.size()).
void evaluate(const Chain& chain, const Eigen::VectorXd& x, ChainKinematics& kinematics);

/// Derivative of the generalised forces J'F of a wrench that is constant in base axes and applied
/// at the end point: result(k, l) = d(J_k . F) / dx_l. With joint i nearer the base than j,
///
///     d(J_j . F)/dx_i = f . (w_i x v_j) + m . (w_i x w_j),    d(J_i . F)/dx_j = f . (w_i x v_j),
///
/// so the force part is symmetric and the moment part is not: a moment constant in fixed axes has
/// no potential. Its antisymmetric part vanishes on motions that hold the end (MMT11 eq. 16, 23).
void wrench_hessian(const Chain& chain, const ChainKinematics& kinematics,
                    const spatial::Vector6& wrench, Eigen::MatrixXd& result);

}  // namespace kinetostat::vjm
