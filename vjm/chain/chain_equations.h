// The equations of equilibrium of one chain, and what in them does not depend on its state.
// Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::vjm {

/// Scale that makes lengths and rotations, forces and moments comparable.
struct Scale {
  double length = 1;     // reach of the longest chain [m]
  double stiffness = 1;  // of the stiffest spring [N/m]

  spatial::Vector6 twist() const;   // twist' = twist() .* twist
  spatial::Vector6 wrench() const;  // wrench' = wrench() .* wrench
};

/// A chain whose end takes the wrench F, whose nodes take loads P, and whose joints take forces t:
///
///     balance:  J'F + sum J_n'P_n + t - K (x - rest) - laws(x) = 0    (MMT11 eq. 5)
///     matrix:   [0 J; J' G-K] with G the derivative of J'F + ...      (MMT11 eq. 28)
///
/// in the coordinates that are free to move (actuated joints without a spring stay put). Everything
/// is made dimensionless by Scale. ChainResiduals has the balance at a state, ChainTangent the
/// matrix. Both refer to the equations, which refer to the chain.
class ChainEquations {
 public:
  /// `commands` [m or rad]: of the actuated joints, given rest values of the passive springs. The
  /// body that the chain starts from moves or does not.
  ///
  /// Redundant passive coordinates are found at a posture, at which `kinematics` are, and not
  /// moved: else the matrix is singular where the chain is balanced and nearly so elsewhere, and
  /// Newton's method goes astray along motions that mean nothing.
  ///
  /// `weight`: a further scale of the coordinates, the root of how much stiffer than
  /// Scale::stiffness is what holds them, where that is in no spring of the chain.
  ChainEquations(const Chain& chain, Eigen::VectorXd commands, const Scale& scale,
                 bool origin_moves, const ChainKinematics& kinematics, double weight = 1);

  const Chain& chain() const { return chain_; }
  const Scale& scale() const { return scale_; }
  const Eigen::VectorXd& commands() const { return commands_; }
  const Eigen::VectorXd& rest() const { return rest_; }
  bool origin_moves() const { return origin_moves_; }

  /// Coordinates of the chain that are free to move, and what scales each: a length [m] or 1, times
  /// the weight.
  const std::vector<Eigen::Index>& free() const { return chain_.free_coordinates(); }
  const Eigen::VectorXd& unit() const { return unit_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(free().size()); }
  /// Numbers of redundant ones among them.
  const std::vector<Eigen::Index>& redundant() const { return redundant_; }
  /// There are directions in which neither a spring nor a passive joint gives way, at the posture.
  bool is_rigid() const { return rigid_; }

  /// 6 x size(): a Jacobian [6 x all coordinates] scaled.
  Eigen::MatrixXd scaled_jacobian(const Matrix6X& jacobian) const;
  /// Generalised forces on all coordinates, as the balance has them: free ones only, scaled.
  void gather_force(const Eigen::VectorXd& full, Eigen::VectorXd& scaled) const;
  Eigen::VectorXd full_increment(const Eigen::VectorXd& scaled) const;
  /// Adds `factor` times that to coordinates.
  void add_increment(const Eigen::VectorXd& scaled, double factor, Eigen::VectorXd& full) const;
  /// The inverse, for the coordinates that are free.
  Eigen::VectorXd scaled_increment(const Eigen::VectorXd& full) const;
  /// Whether a law bends between coordinates; the step to `to` is made shorter as CoordinateLaw has
  /// it.
  bool kinks(const Eigen::VectorXd& from, Eigen::VectorXd& to) const;

 private:
  spatial::Matrix6 products_of_rows(const Matrix6X& jacobian) const;

  const Chain& chain_;
  Eigen::VectorXd commands_, rest_, unit_;
  Scale scale_;
  bool origin_moves_, rigid_ = false;
  std::vector<Eigen::Index> redundant_;
};

}  // namespace kinetostat::vjm
