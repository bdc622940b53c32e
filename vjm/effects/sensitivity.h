// How an equilibrium changes with a parameter of the model: exact derivatives of the solution.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kinetostat/vjm/effects/effect.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/system_state.h"

namespace kinetostat::vjm {

/// A spring of a chain, as a parameter: its stiffness is multiplied as a whole.
struct SpringParameter {
  std::size_t chain = 0;
  std::string spring;

  bool operator==(const SpringParameter&) const = default;
};

/// How the equations of equilibrium change with one parameter, the state held.
struct EquationChange {
  struct OfChain {
    Eigen::VectorXd force;  // generalised forces on all coordinates [N or N m]
    Eigen::VectorXd drive;  // the part of it that drives and links exert
    spatial::Vector6 end = spatial::Vector6::Zero();     // motion of the end [m; rad]
    spatial::Vector6 origin = spatial::Vector6::Zero();  // wrench on the body it starts from
    std::vector<PlaceMotion> motions = {};               // of what is behind a place
  };
  std::vector<OfChain> chains;
  spatial::Vector6 platform_wrench = spatial::Vector6::Zero();  // at the reference point, base axes

  /// Adds `factor` times a column of an effect's derivatives.
  void add(std::size_t chain, const ChainColumns& columns, Eigen::Index column, double factor = 1);
};

/// How the solution changes.
struct StateDerivative {
  spatial::Vector6 platform;                 // [translation m; rotation increment rad], base axes
  Eigen::VectorXd bodies;                    // the same of all bodies, the platform first
  std::vector<Eigen::VectorXd> coordinates;  // all of each chain that was asked for
};

class EquilibriumResiduals;
class NewtonMatrix;

/// Implicit differentiation of the equations of equilibrium at one solution: one factorisation for
/// all parameters.
class EquilibriumDerivatives {
 public:
  /// `at` is a state of equilibrium, and must outlive this.
  explicit EquilibriumDerivatives(const EquilibriumResiduals& at);
  /// The same in the memory of a matrix of the same system elsewhere.
  EquilibriumDerivatives(const EquilibriumResiduals& at, NewtonMatrix matrix);
  EquilibriumDerivatives(EquilibriumDerivatives&&) noexcept;
  ~EquilibriumDerivatives();

  /// Before so many solutions without coordinates.
  void expect(std::size_t solutions) const;
  EquationChange no_change() const;
  /// That again in a change that is kept.
  void make_none(EquationChange& change) const;
  /// Adds the change with the natural logarithm of a spring's stiffness. Throws
  /// std::invalid_argument for an unknown spring.
  void add_log_stiffness(const SpringParameter& spring, EquationChange& change) const;
  /// With the coordinates of some chains.
  StateDerivative solve(const EquationChange& change,
                        const std::vector<std::size_t>& chains = {}) const;
  /// The same into a derivative that is kept.
  void solve(const EquationChange& change, const std::vector<std::size_t>& chains,
             StateDerivative& derivative) const;

 private:
  const EquilibriumResiduals& at_;
  std::unique_ptr<const NewtonMatrix> matrix_;  // with the platform free
};

/// An equilibrium as an effect on a chain sees it. Refers to `at`.
ChainState chain_state(const EquilibriumResiduals& at, std::size_t chain);

/// Derivatives of the platform displacement [m; rad] (base axes) at an equilibrium under `load`
/// with respect to the natural logarithm of each spring's stiffness: one column per parameter.
/// Throws std::invalid_argument for an unknown spring.
Matrix6X displacement_by_log_stiffness(const Manipulator& manipulator, const Posture& posture,
                                       const Load& load, const Equilibrium& equilibrium,
                                       const std::vector<SpringParameter>& parameters);

}  // namespace kinetostat::vjm
