// The Newton matrix factorised chain by chain. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/robust_factor.h"
#include "kinetostat/vjm/statics/equilibrium_tangent.h"

namespace kinetostat::vjm {

/// Every chain by itself, then the bodies that the chains join; not for chains with rigid
/// directions. Vectors that are solved into are kept: from the second call on nothing is allocated,
/// but where a matrix is singular. Solving uses scratch memory: one thread at a time.
class ChainwiseFactor {
 public:
  ChainwiseFactor(const EquilibriumResiduals& at, bool platform_held);
  /// The same at another state.
  void renew(const EquilibriumResiduals& at);
  const EquilibriumTangent& tangent() const { return tangent_; }

  /// False when a singular matrix cannot balance the right-hand side.
  bool solve(const SystemVector& right, SystemVector& solution) const;
  /// The same in two parts: the motion of the bodies, then what it means for the chains of which
  /// that is asked.
  bool solve_bodies(const SystemVector& right, SystemVector& solution) const;
  bool complete(std::size_t chain, const SystemVector& right, SystemVector& solution) const;

  /// Tangent stiffness felt at a chain's end with its start held, unscaled.
  spatial::Matrix6 chain_stiffness(std::size_t chain) const;
  /// dx_i/dt of one chain with its start held, unscaled (K_q and K_theta of MMT11 eq. 29).
  Eigen::MatrixXd chain_motion(std::size_t chain) const;
  /// Tangent stiffness of the platform, inner bodies free to follow, unscaled. The platform must
  /// not be held.
  spatial::Matrix6 platform_stiffness() const;

 private:
  // Of one chain: its factor, and [F; x] for unit displacements of the bodies at its ends.
  struct OfChain {
    RobustFactor factor;
    Eigen::MatrixXd by_end, by_origin, unit;
  };
  struct Scratch {
    Eigen::VectorXd right, solution;
  };

  void factorise();
  void respond(std::size_t chain);
  void add_to_bodies(std::size_t chain, Eigen::MatrixXd& matrix, Eigen::Index to,
                     Eigen::Index from) const;

  EquilibriumTangent tangent_;
  bool held_;
  std::vector<OfChain> chains_;
  Eigen::MatrixXd matrix_;  // of the bodies
  RobustFactor factor_;
  mutable std::vector<Scratch> scratch_;  // of chains
  mutable Eigen::VectorXd balance_, bodies_;
};

}  // namespace kinetostat::vjm
