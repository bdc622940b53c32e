// Direct kinematics of a chain with exact first and second derivatives.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Results of direct kinematics at one state; kept between calls so that no memory is allocated.
struct ChainKinematics {
  spatial::Pose end;      // of the end frame, in base axes
  Matrix6X jacobian;      // 6 x coordinates, [v; w] at the end point, base axes
  Matrix6X joint_twists;  // 6 x joints: the same for each elementary joint alone (factor applied)
  double reach = 0;       // largest distance of a joint from the end point [m]
  std::vector<spatial::Vector3> nodes;  // positions of the chain's nodes, base axes
};

/// Position of the end and geometric Jacobian for coordinates x (size chain.size()). `origin` is
/// where the body that the chain starts from stands.
void evaluate(const Chain& chain, const Eigen::VectorXd& x, ChainKinematics& kinematics,
              const spatial::Pose& origin = {});

/// The frame that the first `joints` joints lead to.
spatial::Pose frame_behind(const Chain& chain, const Eigen::VectorXd& x, Eigen::Index joints,
                           const spatial::Pose& origin = {});

/// A wrench [force; moment] that is constant in base axes and acts at `point`, on the frame that
/// the first `joints` joints of a chain move.
struct PointWrench {
  spatial::Vector6 wrench;
  spatial::Vector3 point;
  Eigen::Index joints;
};

/// The wrench at the end of a chain, and one at a node.
PointWrench at_end(const Chain& chain, const ChainKinematics& kinematics,
                   const spatial::Vector6& wrench);
PointWrench at_node(const Chain& chain, const ChainKinematics& kinematics, std::size_t node,
                    const spatial::Vector6& wrench);

/// Adds the generalised forces J'F of a wrench.
void add_generalised_force(const Chain& chain, const ChainKinematics& kinematics,
                           const PointWrench& load, Eigen::VectorXd& force);

/// Adds the derivative of the generalised forces of some wrenches: hessian(k, l) += d(J_k . F) /
/// dx_l. With joint i nearer the base than j, and the wrenches behind j,
///
///     d(J_j . F)/dx_i = w_i . (v_j x f + w_j x m),    d(J_i . F)/dx_j = w_i . (v_j x f),
///
/// so the force part is symmetric and the moment part is not: a moment constant in fixed axes has
/// no potential. Its antisymmetric part vanishes on motions that hold the end (MMT11 eq. 16, 23).
void add_wrench_hessian(const Chain& chain, const ChainKinematics& kinematics,
                        const std::vector<PointWrench>& loads, Eigen::MatrixXd& hessian);

}  // namespace kinetostat::vjm
