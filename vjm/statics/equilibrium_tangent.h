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
  // Of an elastic body, scaled.
  struct OfElasticBody {
    Eigen::MatrixXd stiffness;
    Eigen::Matrix3Xd by_turn;  // transposed
    spatial::Matrix3 moment;
  };
  // Where its rows are: of its chains' coordinates, and of the turn of its origin's body (negative
  // when that does not move).
  struct Places {
    std::vector<Eigen::Index> coordinates;
    Eigen::Index turn = -1;
  };
  void find_elastic_bodies(const EquilibriumResiduals& at);
  void add_elastic_bodies(bool platform_held, Eigen::MatrixXd& matrix) const;
  void add_elastic_energy(Eigen::MatrixXd& hessian) const;
  Places places_of(const ElasticBody& body, const std::vector<Eigen::Index>& first,
                   bool platform_held) const;

  const EquilibriumSystem* system_;
  std::vector<ChainTangent> chains_;
  std::vector<OfElasticBody> elastic_bodies_;
  spatial::Matrix6 load_matrix_;
};

}  // namespace kinetostat::vjm
