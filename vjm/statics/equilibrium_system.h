// The equations of equilibrium of a manipulator. Internal to this module: equilibrium.h,
// stiffness.h and sensitivity.h are what others use.
//
// Unknowns are the poses t_b of the bodies and, for every chain i, the wrench F_i that the body at
// its end exerts on it and its coordinates x_i:
//
//     end_i(t_from, x_i) = t_to,   balance of each chain (chain_equations.h),
//     sum of F_i that end on b - sum of wrenches of chains that start on b = W_b(t_b)
//
// An elastic body adds -K d, and its weight, to the balances of the chains that lead through it.
// (MMT11 eq. 5, NONPERF eq. 21; for one platform and chains from the base the papers' case).
//
// EquilibriumSystem is what does not change with the state; EquilibriumResiduals is the system at a
// state under a load, EquilibriumTangent its derivative there, NewtonMatrix that factorised.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/chain_equations.h"
#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/statics/system_state.h"

namespace kinetostat::vjm {

/// A right-hand side or a correction, scaled. Rows of the bodies first, six each.
struct SystemVector {
  Eigen::VectorXd bodies;
  std::vector<spatial::Vector6> wrenches;
  std::vector<Eigen::VectorXd> coordinates;

  double norm() const;
};

/// Immutable. Manipulator and posture must outlive it; it must outlive all that is evaluated with
/// it.
class EquilibriumSystem {
 public:
  EquilibriumSystem(const Manipulator& manipulator, const Posture& posture);
  EquilibriumSystem(const EquilibriumSystem&) = delete;
  EquilibriumSystem& operator=(const EquilibriumSystem&) = delete;

  const Manipulator& manipulator() const { return manipulator_; }
  const Posture& posture() const { return posture_; }
  const Scale& scale() const { return scale_; }
  const std::vector<ChainEquations>& chains() const { return chains_; }
  /// True when some chain has directions in which neither a spring nor a passive joint gives way.
  bool has_rigid_directions() const { return rigid_; }
  /// True when chains can be eliminated one by one: each has a stiffness, and no elastic body
  /// couples several.
  bool is_chainwise() const { return !rigid_ && manipulator_.elastic_bodies().empty(); }
  /// The posture, with no load. Geometric errors and preloads leave residuals in it.
  SystemState relaxed_state() const;

  SystemVector zero() const;
  void make_zero(SystemVector& vector) const;
  /// A vector of the system in one, without the platform's rows when that is held: bodies, then
  /// [F_i; x_i] of each chain.
  Eigen::VectorXd flat(const SystemVector& vector, bool platform_held) const;
  SystemVector from_flat(const Eigen::VectorXd& flat, bool platform_held) const;
  /// The same into vectors that are kept: from the second call on nothing is allocated.
  void flat(const SystemVector& vector, bool platform_held, Eigen::VectorXd& flat) const;
  void from_flat(const Eigen::VectorXd& flat, bool platform_held, SystemVector& vector) const;

  SystemState moved(const SystemState& state, const SystemVector& correction, double factor) const;
  void moved(const SystemState& state, const SystemVector& correction, double factor,
             SystemState& next) const;
  /// The correction that leads from one state to another nearby.
  SystemVector difference(const SystemState& from, const SystemState& to) const;
  /// Whether a law bends between two states; the step to `to` is made shorter as CoordinateLaw has
  /// it.
  bool kinks(const SystemState& from, SystemState& to) const;
  /// Deflections of an elastic body in a state.
  static Eigen::VectorXd deflections(const ElasticBody& body, const SystemState& state);
  /// The body that a body of the manipulator, or the base, is in a state.
  static const spatial::Pose& pose(int body, const SystemState& state);

  /// Size of the wrenches between chains and bodies in a state, scaled.
  double wrench_norm(const SystemState& state) const;

  /// First of the six rows of a body in the Newton matrix; negative when it does not move.
  Eigen::Index row_of(int body, bool platform_held) const {
    return body == Span::base ? -1 : Eigen::Index{6} * (body - (platform_held ? 1 : 0));
  }
  /// Rows of all bodies there.
  Eigen::Index body_rows(bool platform_held) const {
    return 6 * (static_cast<Eigen::Index>(manipulator_.body_count()) - (platform_held ? 1 : 0));
  }

 private:
  const Manipulator& manipulator_;
  const Posture& posture_;
  Scale scale_;
  std::vector<ChainEquations> chains_;
  bool rigid_ = false;
};

}  // namespace kinetostat::vjm
