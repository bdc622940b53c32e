// The equations of equilibrium of one chain and their derivatives. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/chain/robust_factor.h"

namespace kinetostat::vjm {

/// Scale that makes lengths and rotations, forces and moments comparable.
struct Scale {
  double length = 1;     // reach of the longest chain [m]
  double stiffness = 1;  // of the stiffest spring [N/m]

  spatial::Vector6 twist() const;   // twist' = twist() .* twist
  spatial::Vector6 wrench() const;  // wrench' = wrench() .* wrench
};

/// A chain whose end takes the wrench F and whose nodes take loads P:
///
///     balance:  J'F + sum J_n'P_n - K (x - rest) - laws(x) = 0        (MMT11 eq. 5)
///     matrix:   [0 J; J' G-K] with G the derivative of J'F + ...      (MMT11 eq. 28)
///
/// in the coordinates that are free to move (actuated joints without a spring stay put). Everything
/// is made dimensionless by Scale. When the chain starts from a body that moves, `origin` is that
/// body's pose, and the derivatives with respect to its displacement are given too.
class ChainEquations {
 public:
  /// `commands` [m or rad]: of the actuated joints, given rest values of the passive springs.
  ChainEquations(const Chain& chain, Eigen::VectorXd commands, const Scale& scale,
                 bool origin_moves);

  void set(const spatial::Pose& origin, const Eigen::VectorXd& x, const spatial::Vector6& wrench);
  /// Loads at nodes, [force; moment] in base axes; kept until cleared.
  void clear_node_loads() { node_loads_.clear(); }
  void add_node_load(std::size_t node, const spatial::Vector6& wrench);
  /// Builds the matrix at the last state set; factorises it when asked to.
  void linearise(bool factorise);
  /// From now on redundant passive coordinates are not moved, found at the last state set: else the
  /// matrix is singular where the chain is balanced and nearly so elsewhere, and Newton's method
  /// goes astray along motions that mean nothing.
  void hold_redundant();
  /// Numbers of them among the free coordinates; none while nodes are loaded, which may turn them.
  /// Their rows in matrix() say dx = 0.
  const std::vector<Eigen::Index>& held() const;

  Eigen::Index size() const { return static_cast<Eigen::Index>(free_.size()); }
  bool origin_moves() const { return origin_moves_; }
  const spatial::Pose& end() const { return kinematics_.end; }
  const Eigen::MatrixXd& matrix() const { return matrix_; }
  const RobustFactor& factor() const { return factor_; }

  /// Left side of the balance, scaled.
  void unbalanced(Eigen::VectorXd& result) const;
  /// Wrench of the chain on the body it starts from, about that body's origin; unscaled.
  spatial::Vector6 wrench_on_origin() const;
  /// 6 x size() Jacobian, scaled.
  Eigen::MatrixXd jacobian() const;
  /// Second derivative of the energy, scaled: -(lower block + its transpose) / 2.
  Eigen::MatrixXd energy_hessian() const;
  /// Rounding of the energy, as EnergyHessian has it.
  Eigen::VectorXd energy_rounding() const;

  /// With a moving origin, scaled: displacement of the end (6x6), derivative of the balance
  /// (size() x 6), of the wrench on the origin with respect to x (6 x size()) and to the origin
  /// (6x6).
  const spatial::Matrix6& end_by_origin() const { return end_by_origin_; }
  const Eigen::MatrixXd& balance_by_origin() const { return balance_by_origin_; }
  const Eigen::MatrixXd& origin_by_balance() const { return origin_by_balance_; }
  const spatial::Matrix6& origin_by_origin() const { return origin_by_origin_; }

  /// Derivative of the generalised forces on all coordinates with respect to the logarithm of one
  /// spring's stiffness; gather_force() brings it to the balance.
  Eigen::VectorXd force_by_log_stiffness(const Spring& spring) const;
  /// Generalised forces on all coordinates, as the balance has them: free ones only, scaled.
  Eigen::VectorXd gather_force(const Eigen::VectorXd& full) const;
  /// The state that is set, for derivatives of its generalised forces.
  Eigen::VectorXd deflection() const { return x_ - rest_; }
  Eigen::VectorXd travel() const { return x_ - commands_; }
  const spatial::Pose& origin() const { return origin_; }
  /// The wrench at the end, then those at nodes.
  std::vector<PointWrench> loads() const;
  const Eigen::VectorXd& coordinates() const { return x_; }
  const ChainKinematics& kinematics() const { return kinematics_; }

  /// Elastic energy of springs and laws [J].
  double energy() const;

  Eigen::VectorXd full_increment(const Eigen::VectorXd& scaled) const;
  /// Adds `factor` times that to coordinates.
  void add_increment(const Eigen::VectorXd& scaled, double factor, Eigen::VectorXd& full) const;
  /// Whether a law bends between coordinates; the step to `to` is made shorter as CoordinateLaw has
  /// it.
  bool kinks(const Eigen::VectorXd& from, Eigen::VectorXd& to) const;
  /// The inverse, for the coordinates that are free.
  Eigen::VectorXd scaled_increment(const Eigen::VectorXd& full) const;

 private:
  template <class Use>
  void for_each_load(const Use& use) const;
  double scaled_hessian(Eigen::Index k, Eigen::Index l) const;
  void linearise_origin();

  const Chain& chain_;
  Eigen::VectorXd commands_, rest_, unit_;
  Scale scale_;
  bool origin_moves_;
  std::vector<Eigen::Index> free_;
  std::vector<Eigen::Index> redundant_;  // among the free ones
  std::vector<std::pair<std::size_t, spatial::Vector6>> node_loads_;
  spatial::Pose origin_;
  ChainKinematics kinematics_;
  Eigen::VectorXd x_;
  spatial::Vector6 wrench_ = spatial::Vector6::Zero();
  Eigen::MatrixXd hessian_, matrix_;
  // Kept, so that Newton's method allocates nothing from its second correction on.
  mutable Eigen::VectorXd force_, deflection_, travel_;
  Eigen::MatrixXd by_x_, by_origin_;
  RobustFactor factor_;
  spatial::Matrix6 end_by_origin_ = spatial::Matrix6::Zero();
  spatial::Matrix6 origin_by_origin_ = spatial::Matrix6::Zero();
  Eigen::MatrixXd balance_by_origin_, origin_by_balance_;
};

}  // namespace kinetostat::vjm
