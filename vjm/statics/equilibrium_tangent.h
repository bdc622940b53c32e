// The derivative of the equations of equilibrium at a state. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/chain_tangent.h"
#include "kinetostat/vjm/statics/equilibrium_residuals.h"
#include "kinetostat/vjm/statics/stability.h"

namespace kinetostat::vjm {

/// The Newton matrix and the second derivative of the energy, scaled. Of the residuals that it is
/// built from it keeps what it needs: these may move on.
class EquilibriumTangent {
 public:
  explicit EquilibriumTangent(const EquilibriumResiduals& at);
  /// The same at another state. Allocates nothing.
  void renew(const EquilibriumResiduals& at);

  const EquilibriumSystem& system() const { return *system_; }
  const std::vector<ChainTangent>& chains() const { return chains_; }
  const spatial::Matrix6& load_matrix() const { return load_matrix_; }

  /// The Newton matrix, all unknowns in one; EquilibriumSystem::flat() has their order.
  Eigen::MatrixXd matrix(bool platform_held) const;
  /// The same into a matrix that is kept.
  void matrix(bool platform_held, Eigen::MatrixXd& matrix) const;

  /// On all motions that keep the chains together, with the platform held (MMT11 eq. 23) or free
  /// under its dead load. Rows: bodies (without the platform when it is held), then the coordinates
  /// of all chains.
  EnergyHessian energy_hessian(bool platform_held) const;
  /// The same for one chain with both its ends held.
  EnergyHessian chain_energy_hessian(std::size_t chain) const;
  /// Motions [6 x any] of the platform that cost no energy, unscaled.
  Matrix6X motions_without_energy() const;

 private:
  const EquilibriumSystem* system_;
  std::vector<ChainTangent> chains_;
  spatial::Matrix6 load_matrix_;
};

}  // namespace kinetostat::vjm
