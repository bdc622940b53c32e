// The equations of equilibrium of a manipulator and their Newton matrix. Internal to this module:
// equilibrium.h, stiffness.h and sensitivity.h are what others use.
//
// Unknowns are the poses t_b of the bodies and, for every chain i, the wrench F_i that the body at
// its end exerts on it and its coordinates x_i:
//
//     end_i(t_from, x_i) = t_to,   balance of each chain (chain_equations.h),
//     sum of F_i that end on b - sum of wrenches of chains that start on b = W_b(t_b)
//
// (MMT11 eq. 5, NONPERF eq. 21; for one platform and chains from the base the papers' case).
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/chain_equations.h"
#include "kinetostat/vjm/chain/robust_factor.h"
#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/statics/load.h"
#include "kinetostat/vjm/statics/stability.h"
#include "kinetostat/vjm/statics/system_state.h"

namespace kinetostat::vjm {

/// A right-hand side or a correction, scaled. Rows of the bodies first, six each.
struct SystemVector {
  Eigen::VectorXd bodies;
  std::vector<spatial::Vector6> wrenches;
  std::vector<Eigen::VectorXd> coordinates;

  double norm() const;
};

class EquilibriumSystem {
 public:
  EquilibriumSystem(const Manipulator& manipulator, const Posture& posture);

  const Manipulator& manipulator() const { return manipulator_; }
  const Scale& scale() const { return scale_; }
  const std::vector<ChainEquations>& chains() const { return chains_; }
  /// The posture, with no load. Geometric errors and preloads leave residuals in it.
  SystemState relaxed_state() const;

  /// Evaluates the residuals at a state.
  void set(const SystemState& state, const Load& load);
  /// Says whether the platform is held, in all that follows, or free to move.
  void hold_platform(bool held) { held_ = held; }
  /// Builds and factorises the Newton matrix there.
  void linearise(bool platform_held);
  /// The same with the platform free and every chain factorised by itself, which the stiffness of
  /// chains and platform needs. Not for rigid chains.
  void linearise_by_chains();

  /// The Newton matrix at the state that is set, all unknowns in one: bodies (without the platform
  /// when it is held), then [F_i; x_i] of each chain. flat() puts vectors in that order.
  Eigen::MatrixXd dense_matrix();
  Eigen::VectorXd flat(const SystemVector& vector) const;
  SystemVector from_flat(const Eigen::VectorXd& flat) const;

  SystemVector zero() const;
  /// Minus the residuals: right-hand side of a Newton step.
  SystemVector newton_right_hand_side() const;
  SystemVector solve(const SystemVector& right) const;
  /// The same into vectors that are kept: from the second call on nothing is allocated, but where
  /// the Newton matrix is singular.
  void newton_right_hand_side(SystemVector& right) const;
  void solve(const SystemVector& right, SystemVector& solution) const;
  /// The same in two parts: the motion of the bodies, then what it means for the chains of which
  /// that is asked.
  void solve_bodies(const SystemVector& right, SystemVector& solution) const;
  void complete(std::size_t chain, const SystemVector& right, SystemVector& solution) const;
  /// False when the last solve() met a right-hand side that the singular matrix cannot balance.
  bool consistent() const { return consistent_; }
  SystemState moved(const SystemState& state, const SystemVector& correction, double factor) const;
  void moved(const SystemState& state, const SystemVector& correction, double factor,
             SystemState& next) const;
  /// Whether a law bends between two states; the step to `to` is made shorter as CoordinateLaw has
  /// it.
  bool kinks(const SystemState& from, SystemState& to) const;
  /// Size of the wrenches between chains and bodies in a state, scaled.
  double wrench_norm(const SystemState& state) const;
  /// The correction that leads from one state to another nearby.
  SystemVector difference(const SystemState& from, const SystemState& to) const;

  /// Wrench on the platform that the chains hold in equilibrium with, unscaled, base axes.
  spatial::Vector6 platform_wrench() const;
  /// Tangent stiffness felt at a chain's end with its start held, unscaled; requires
  /// linearise_by_chains().
  spatial::Matrix6 chain_stiffness(std::size_t chain) const;
  /// dx_i/dt of one chain with its start held, unscaled (K_q and K_theta of MMT11 eq. 29).
  Eigen::MatrixXd chain_motion(std::size_t chain) const;
  /// Tangent stiffness of the platform, inner bodies free to follow, unscaled; same requirements.
  spatial::Matrix6 platform_stiffness() const;
  /// Compliance of the platform under the load, unscaled; requires linearise(false). consistent()
  /// is false afterwards when some motion is free.
  spatial::Matrix6 platform_compliance() const;
  /// True when some chain has directions in which neither a spring nor a passive joint gives way.
  bool has_rigid_directions() const { return rigid_; }
  /// Scaled, on all motions that keep the chains together, with the platform held (MMT11 eq. 23) or
  /// free under its dead load. Rows: bodies (without the platform when it is held), then the
  /// coordinates of all chains.
  EnergyHessian energy_hessian(bool platform_held) const;
  /// Values for those rows as a vector of the system.
  SystemVector motion(const Eigen::VectorXd& bodies_and_coordinates) const;
  /// The same for one chain with both its ends held.
  EnergyHessian chain_energy_hessian(std::size_t chain) const;
  /// Motions [6 x any] of the platform that cost no energy at the state that is set.
  Matrix6X motions_without_energy() const;

 private:
  Eigen::Index free_bodies() const;
  /// First row of a body in the Newton matrix; negative when it does not move.
  Eigen::Index row_of(int body) const;
  bool one_dense_matrix() const { return rigid_ || (chains_.size() == 1 && !held_); }
  spatial::Matrix6 load_matrix() const;
  void factorise_by_chains();
  void build_dense(Eigen::MatrixXd& matrix);
  void set_node_loads(std::size_t chain);
  void solve_dense(const SystemVector& right, SystemVector& solution) const;
  void solve_bodies_by_chains(const SystemVector& right, SystemVector& solution) const;
  void solve_chain(std::size_t chain, const SystemVector& right, SystemVector& solution) const;
  void flat(const SystemVector& vector, Eigen::VectorXd& z) const;
  void from_flat(const Eigen::VectorXd& z, SystemVector& vector) const;
  void make_zero(SystemVector& vector) const;
  void add_chain_to_bodies(std::size_t chain, Eigen::MatrixXd& matrix, Eigen::Index to,
                           Eigen::Index from) const;

  const Manipulator& manipulator_;
  const Posture& posture_;
  Scale scale_;
  std::vector<ChainEquations> chains_;
  std::vector<Eigen::MatrixXd> by_end_, by_origin_;  // of [F; x], per chain, by chains
  SystemState state_;
  Load load_;
  bool rigid_ = false, held_ = false;
  RobustFactor factor_;  // of the bodies by chains, of everything when dense
  mutable bool consistent_ = true;
  // Kept, so that Newton's method allocates nothing from its second correction on.
  Eigen::MatrixXd newton_matrix_;
  std::vector<Eigen::MatrixXd> unit_;                                  // per chain
  mutable std::vector<Eigen::VectorXd> chain_right_, chain_solution_;  // per chain
  mutable Eigen::VectorXd flat_right_, flat_solution_, balance_;
};

}  // namespace kinetostat::vjm
