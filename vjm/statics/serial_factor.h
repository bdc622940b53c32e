// The Newton matrix of one chain from the base to the platform. Internal to this module.
#pragma once

#include "kinetostat/vjm/chain/robust_factor.h"
#include "kinetostat/vjm/statics/equilibrium_tangent.h"

namespace kinetostat::vjm {

/// For a serial arm with its platform free, without rigid directions. The platform's balance and
/// the gap give F = r_b + L t and t = J x - r_g, so that only the coordinates are left:
///
///     (H + J'L J) x = r_x - J'(r_b - L r_g)
///
/// with the chain's matrix [0 J; J' H] (ChainEquations) and the derivative L of the load. Allocates
/// and uses scratch memory as ChainwiseFactor does.
class SerialFactor {
 public:
  /// Whether this is such a system.
  static bool can_factorise(const EquilibriumSystem& system, bool platform_held);

  explicit SerialFactor(const EquilibriumResiduals& at);
  /// The same at another state.
  void renew(const EquilibriumResiduals& at);

  /// False when a singular matrix cannot balance the right-hand side.
  bool solve(const SystemVector& right, SystemVector& solution) const;
  /// The motion of the platform alone. After prepare_bodies(), which pays for more right-hand sides
  /// than a body has motions, with J A^-1 instead of the matrix A: no coordinates are found.
  bool solve_bodies(const SystemVector& right, SystemVector& solution) const;
  void prepare_bodies() const;

 private:
  void factorise();

  EquilibriumTangent tangent_;
  Matrix6X loaded_;  // L J
  Eigen::MatrixXd matrix_;
  RobustFactor factor_;
  void find_right(const SystemVector& right) const;

  mutable Eigen::VectorXd right_;
  // The transpose of J A^-1; empty: not prepared.
  mutable Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> body_motion_;
};

}  // namespace kinetostat::vjm
