// Equilibria of a manipulator along one parameter, as equations that do not care whether the
// parameter turns back. Internal to this module: path.h is what others use.
#pragma once

#include "kinetostat/vjm/continuation/path_result.h"
#include "kinetostat/vjm/statics/equilibrium_tangent.h"

namespace kinetostat::vjm {

struct PathState {
  SystemState state;
  double parameter = 0;
};

/// The equations of a path linearised at a state.
class LinearisedPath {
 public:
  LinearisedPath(EquilibriumTangent tangent, Eigen::MatrixXd derivative, bool platform_held)
      : tangent_(std::move(tangent)), derivative_(std::move(derivative)), held_(platform_held) {}

  /// Of the residuals, n x (n + 1).
  const Eigen::MatrixXd& derivative() const { return derivative_; }
  /// Of the energy on the motions that the task allows. Empty where no motion is left.
  EnergySpectrum spectrum() const { return energy_spectrum(tangent_.energy_hessian(held_)); }

 private:
  EquilibriumTangent tangent_;
  Eigen::MatrixXd derivative_;
  bool held_;
};

/// Residuals r(y, p) = 0 of the equilibrium and their derivatives, in the n unknowns y of the
/// system and the parameter p. A vector of the path has n + 1 entries, dimensionless: the flat
/// system vector, then the change of p times a weight that makes both comparable.
class PathEquations {
 public:
  PathEquations(const Manipulator& manipulator, const Posture& posture, const PathTask& task);

  const PathTask& task() const { return task_; }
  const Scale& scale() const { return system_.scale(); }
  double weight() const { return weight_; }

  /// An equilibrium at the parameter, by Newton's method from the relaxed posture; the status
  /// says whether there is one.
  EquilibriumStatus start(double parameter, PathState& state, std::string& reason) const;
  /// Chooses the weight of the parameter from how the equilibrium moves with it here.
  void balance_weight(const PathState& at);

  /// -r at a state.
  Eigen::VectorXd right_hand_side(const PathState& at) const;
  LinearisedPath linearised(const PathState& at) const;
  PathState moved(const PathState& from, const Eigen::VectorXd& change) const;
  /// The change that leads from one state to another nearby.
  Eigen::VectorXd difference(const PathState& from, const PathState& to) const;
  /// The same without full turns of the joints that have neither spring nor law: a chain stands
  /// after them as it stood before.
  Eigen::VectorXd separation(const PathState& from, const PathState& to) const;
  /// Norm of the part of a vector that moves bodies and coordinates.
  double motion(const Eigen::VectorXd& change) const;
  /// Whether the tangent of some law (CoordinateLaw) differs between two states by more than
  /// `share` of itself: between neighbours it has a jump there.
  bool law_differs(const PathState& a, const PathState& b, double share) const;

  /// A direction in which the wrench that the held platform exerts along its displacement grows.
  Eigen::VectorXd push() const;

  /// `tangent` gives the slope of force against deflection; there is none at a critical point.
  PathPoint describe(const PathState& at, const Eigen::VectorXd* tangent = nullptr) const;

 private:
  EquilibriumResiduals residuals(const SystemState& state, double parameter) const;
  Eigen::VectorXd flat_right_hand_side(const EquilibriumResiduals& at) const;
  Eigen::MatrixXd derivative(const EquilibriumTangent& tangent,
                             const Eigen::VectorXd& by_load) const;
  std::vector<double> law_tangents(const PathState& at) const;
  std::optional<Along> along(const Equilibrium& equilibrium, const Eigen::VectorXd* tangent) const;
  spatial::Vector6 platform_wrench_rate(const SystemVector& rate) const;
  double work_of_weight(const ElasticBody& body, const SystemState& state, const Load& load) const;
  /// Elastic energy less the work of dead forces since the posture [J]; none when a moment acts,
  /// which has no potential.
  std::optional<double> potential(const Equilibrium& equilibrium, const Load& load) const;

  const Manipulator& manipulator_;
  const Posture& posture_;
  PathTask task_;
  EquilibriumSystem system_;
  std::vector<std::vector<Eigen::Index>> turning_;  // coordinates of each chain, for separation()
  double weight_;
};

}  // namespace kinetostat::vjm
