// The equations of equilibrium of a manipulator and their Newton matrix. Internal to this room:
// equilibrium.h, stiffness.h and sensitivity.h are what others use.
//
// Unknowns are the platform pose t and, for every chain i, the wrench F_i that the platform exerts
// on its end and its coordinates x_i (actuated joints without a spring stay put):
//
//     end_i(x_i) = t,    J_i' F_i = K_i (x_i - rest_i),    sum F_i = W(t)      (MMT11 eq. 5,
//     NONPERF eq. 21)
//
// Everything is made dimensionless in the same way: rotations times a length, forces over a
// stiffness.
#pragma once

#include <vector>

#include <Eigen/LU>
#include <Eigen/QR>

#include "kinetostat/vjm/kinematics.h"
#include "kinetostat/vjm/manipulator.h"

namespace kinetostat::vjm {

/// What makes lengths and rotations, forces and moments comparable.
struct Scale {
  double length = 1;     // reach of the longest chain [m]
  double stiffness = 1;  // of the stiffest spring [N/m]

  spatial::Vector6 twist() const;   // twist' = twist() .* twist
  spatial::Vector6 wrench() const;  // wrench' = wrench() .* wrench
};

/// A dead load: force and moment constant in base axes, at a point fixed to the platform.
struct Load {
  spatial::Vector3 force = spatial::Vector3::Zero();              // [N]
  spatial::Vector3 moment = spatial::Vector3::Zero();             // about `point` [N m]
  spatial::Vector3 point_on_platform = spatial::Vector3::Zero();  // [m], platform axes

  /// [force; moment about the platform's reference point].
  spatial::Vector6 at_reference_point(const spatial::Pose& platform) const;
  /// Derivative of that with respect to a displacement of the platform.
  spatial::Matrix6 derivative(const spatial::Pose& platform) const;
  Load scaled(double factor) const { return {factor * force, factor * moment, point_on_platform}; }
};

/// The unknowns, or (as a Newton correction or right-hand side) their scaled increments.
struct SystemVector {
  spatial::Vector6 platform = spatial::Vector6::Zero();
  std::vector<spatial::Vector6> wrenches;
  std::vector<Eigen::VectorXd> coordinates;

  double norm() const;
};

struct SystemState {
  spatial::Pose platform;
  std::vector<spatial::Vector6> wrenches;    // on the chain ends, base axes
  std::vector<Eigen::VectorXd> coordinates;  // all of each chain
};

/// LU where it is safe, a rank-revealing orthogonal decomposition (least squares, shortest
/// solution) where pivots vanish: redundant passive joints and indeterminate reactions.
class RobustFactor {
 public:
  void compute(const Eigen::MatrixXd& matrix);
  /// `consistent` becomes false when no solution exists.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right, bool* consistent = nullptr) const;
  bool singular() const { return singular_; }

 private:
  Eigen::MatrixXd matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> orthogonal_;
  bool singular_ = false;
};

/// One chain: [0 J; J' G-K] with G the derivative of J'F (MMT11 eq. 28), scaled.
class ChainEquations {
 public:
  ChainEquations(const Chain& chain, Eigen::VectorXd rest, const Scale& scale);

  void set(const Eigen::VectorXd& x, const spatial::Vector6& wrench);
  /// Builds the matrix at the last state set; factorises it when asked to.
  void linearise(bool factorise);

  Eigen::Index size() const { return static_cast<Eigen::Index>(free_.size()); }
  const spatial::Pose& end() const { return kinematics_.end; }
  const Eigen::MatrixXd& matrix() const { return matrix_; }
  const RobustFactor& factor() const { return factor_; }
  /// J'F - K(x - rest) of the free coordinates, scaled.
  Eigen::VectorXd unbalanced() const;
  /// 6 x size() Jacobian of the free coordinates, scaled.
  Eigen::MatrixXd jacobian() const;
  /// K - (G + G')/2 of the free coordinates, scaled: second derivative of the energy.
  Eigen::MatrixXd energy_hessian() const;
  /// Derivative of unbalanced() with respect to the logarithm of one spring's stiffness.
  Eigen::VectorXd unbalanced_by_log_stiffness(const Spring& spring) const;
  double energy() const;  // [J]

  Eigen::VectorXd full_increment(const Eigen::VectorXd& scaled) const;
  Eigen::VectorXd scaled_increment(const Eigen::VectorXd& full) const;

 private:
  Eigen::VectorXd gather_force(const Eigen::VectorXd& full) const;

  const Chain& chain_;
  Eigen::VectorXd rest_, unit_;
  Scale scale_;
  std::vector<Eigen::Index> free_;
  ChainKinematics kinematics_;
  Eigen::VectorXd x_;
  spatial::Vector6 wrench_ = spatial::Vector6::Zero();
  Eigen::MatrixXd hessian_, matrix_;
  RobustFactor factor_;
};

/// All chains and the platform.
class EquilibriumSystem {
 public:
  EquilibriumSystem(const Manipulator& manipulator, const Posture& posture);

  const Scale& scale() const { return scale_; }
  const std::vector<ChainEquations>& chains() const { return chains_; }
  SystemState relaxed_state() const;

  /// Evaluates the residuals at a state.
  void set(const SystemState& state, const Load& load);
  /// Builds and factorises the Newton matrix there: with the platform held, or free to move.
  void linearise(bool platform_held);

  /// Minus the residuals: right-hand side of a Newton step.
  SystemVector newton_right_hand_side() const;
  SystemVector solve(const SystemVector& right) const;
  /// False when the last solve() met a right-hand side that the singular matrix cannot balance.
  bool consistent() const { return consistent_; }
  SystemState moved(const SystemState& state, const SystemVector& correction, double factor) const;

  /// Tangent stiffness felt at the platform from one chain, unscaled; requires linearise() and that
  /// the chain is not rigid.
  spatial::Matrix6 chain_stiffness(std::size_t chain) const;
  /// dx_i/dt of one chain, unscaled (K_q and K_theta of MMT11 eq. 29); size of all coordinates.
  Eigen::MatrixXd chain_motion(std::size_t chain) const;
  /// Compliance of the platform under the load, unscaled; requires linearise(false).
  spatial::Matrix6 platform_compliance();
  /// True when some chain has directions in which neither a spring nor a passive joint gives way.
  bool has_rigid_directions() const { return rigid_; }
  /// Smallest eigenvalues decide stability; scaled. Second derivative of the energy on all motions
  /// that keep the chains on the platform (platform free, dead load).
  Eigen::MatrixXd free_energy_hessian() const;
  /// The same for one chain with the platform held (MMT11 eq. 23).
  Eigen::MatrixXd held_energy_hessian(std::size_t chain) const;

 private:
  bool one_dense_matrix() const { return rigid_ || chains_.size() == 1; }
  void linearise_dense();
  void linearise_by_chains();
  SystemVector solve_dense(const SystemVector& right) const;
  SystemVector solve_by_chains(const SystemVector& right) const;
  SystemVector zero() const;

  const Manipulator& manipulator_;
  const Posture& posture_;
  Scale scale_;
  std::vector<ChainEquations> chains_;
  SystemState state_;
  Load load_;
  bool rigid_ = false, held_ = false;
  RobustFactor platform_factor_;  // 6x6 by chains, everything when dense
  mutable bool consistent_ = true;
};

/// Columns spanning the null space of a matrix, orthonormal; singular values below `tolerance`
/// times the largest count as zero.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& matrix, double tolerance = 1e-10);

}  // namespace kinetostat::vjm
