// The equations of equilibrium at a state. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/chain_residuals.h"
#include "kinetostat/vjm/statics/equilibrium_system.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

/// What is left of the equations of a system at a state under a load.
class EquilibriumResiduals {
 public:
  EquilibriumResiduals(const EquilibriumSystem& system, const SystemState& state, const Load& load);
  /// The same under the same load at another state. Allocates nothing.
  void move_to(const SystemState& state);

  const EquilibriumSystem& system() const { return *system_; }
  const SystemState& state() const { return state_; }
  const Load& load() const { return load_; }
  const std::vector<ChainResiduals>& chains() const { return chains_; }

  /// Minus the residuals: right-hand side of a Newton step, with the platform held or free to move.
  SystemVector newton_right_hand_side(bool platform_held) const;
  /// The same into a vector that is kept: from the second call on nothing is allocated.
  void newton_right_hand_side(bool platform_held, SystemVector& right) const;
  /// Wrench on the platform that the chains hold in equilibrium with, unscaled, base axes.
  spatial::Vector6 platform_wrench() const;
  /// Of an elastic body of the manipulator, with the share of gravity that acts.
  ElasticForces forces(const ElasticBody& body) const;
  ElasticTangent tangent(const ElasticBody& body) const;
  /// Derivative of the load on the platform with respect to its displacement, scaled.
  spatial::Matrix6 load_matrix() const;

 private:
  void add_elastic_bodies(SystemVector& right) const;
  const spatial::Pose& origin_of(std::size_t chain) const;

  const EquilibriumSystem* system_;
  SystemState state_;
  Load load_;
  std::vector<ChainResiduals> chains_;
};

}  // namespace kinetostat::vjm
