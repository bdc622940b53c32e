// The published formulas for the stiffness of a chain or manipulator (MMT11 Table 1), each as a
// function of its own. They agree with each other and with unloaded_stiffness(), which is what the
// program uses; docs/theory/unloaded-stiffness.md says which formula holds where.
#pragma once

#include <vector>

#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::vjm {

/// Quantities of the papers' formulas, for one chain in one posture, springs relaxed. Jacobians at
/// the end point, base axes, SI.
struct VirtualJointModel {
  Matrix6X springs = {};           // J_theta: actuators, links, passive joints with a spring
  Eigen::MatrixXd stiffness = {};  // K_theta, symmetric positive definite
  Matrix6X passive = {};           // J_q: perfect passive joints
  double length = 1;  // reach of the chain [m]; makes rotations comparable in rank decisions
};
VirtualJointModel virtual_joint_model(const Chain& chain, const ChainKinematics& kinematics);

/// Salisbury 1980: K_c = J^-T K J^-1 of a serial manipulator whose `jacobian` (6x6) is that of its
/// springs. Throws std::domain_error when it is singular.
spatial::Matrix6 salisbury_stiffness(const spatial::Matrix6& jacobian,
                                     const Eigen::MatrixXd& stiffness);

/// Gosselin 1990: K_c = B' K B of a parallel manipulator with elastic actuators and rigid links,
/// where the rows of `inverse_jacobian` (actuators x 6) give the rates of the actuators for a twist
/// of the platform, B = J^-1. It needs no inverse, so that redundant and singular platforms (IROS11
/// eq. 25) have their matrix too.
spatial::Matrix6 gosselin_stiffness(
    const Eigen::Matrix<double, Eigen::Dynamic, 6>& inverse_jacobian,
    const Eigen::MatrixXd& stiffness);

/// Zhang et al.: K_c = (J_theta K_theta^-1 J_theta')^-1 of a chain without passive joints, or with
/// them locked; K_c^0 of IROS11 eq. 9. Throws std::domain_error when there are fewer than six
/// independent springs (IROS11 remark 1).
spatial::Matrix6 locked_stiffness(const VirtualJointModel& model);

/// MMT11 Table 1, IROS11 eq. 7: upper left block of [J_theta K_theta^-1 J_theta', J_q; J_q', 0]^-1.
/// Redundant passive joints would make it singular: J_q is replaced by a basis of its columns,
/// which allows the same motions. Throws std::domain_error when a wrench that the passive joints
/// transmit meets no spring.
spatial::Matrix6 block_inverse_stiffness(const VirtualJointModel& model);

/// IROS11 eq. 9: K_c = K_c^0 - K_c^0 J_q (J_q' K_c^0 J_q)^-1 J_q' K_c^0, J_q as above. Throws
/// std::domain_error as locked_stiffness().
spatial::Matrix6 two_term_stiffness(const VirtualJointModel& model);

/// IROS11 eq. 10 and 15: one passive joint after the other, K <- K - u u' / mu with u = K J_q and
/// mu = J_q' u. A joint that is redundant to those before it has mu = 0 and changes nothing. Throws
/// std::domain_error as locked_stiffness().
spatial::Matrix6 recursive_stiffness(const VirtualJointModel& model);

/// IROS11 eq. 15 for one passive joint with Jacobian column `passive`; unchanged when mu is not
/// above `redundant`.
spatial::Matrix6 with_passive_joint(const spatial::Matrix6& stiffness,
                                    const spatial::Vector6& passive, double redundant);

/// IROS11 eq. 19-20: a passive joint along or about axis p (0 to 5: x y z, about x y z) at the
/// reference point: K_jk <- K_jk - K_jp K_pk / K_pp, row and column p vanish. The paper prints K_jk
/// K_kj in the numerator, a misprint: its own eq. 4 and 15 have the product used here.
spatial::Matrix6 with_trivial_joint(const spatial::Matrix6& stiffness, int axis);

/// Alici and Shirinzadeh, Chen and Kao (MMT11 Table 1): K_c = J^-T (K_theta - K_F) J^-1 of a serial
/// manipulator under load, K_F the derivative of J'F by the joints. `jacobian` is square. Throws
/// std::domain_error when it is singular.
spatial::Matrix6 loaded_serial_stiffness(const spatial::Matrix6& jacobian,
                                         const Eigen::MatrixXd& stiffness,
                                         const Eigen::MatrixXd& stiffness_by_load);

/// IROS11 eq. 12-13: chains that end at other points of a rigid platform, K = sum J_v' K_i J_v with
/// v_i from the chain's end to the reference point; base axes.
struct ChainAtPoint {
  spatial::Matrix6 stiffness;
  spatial::Vector3 end;  // where it is taken [m]
};
spatial::Matrix6 aggregated_stiffness(const std::vector<ChainAtPoint>& chains,
                                      const spatial::Vector3& reference_point);

}  // namespace kinetostat::vjm
