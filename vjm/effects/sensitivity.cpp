#include "kinetostat/vjm/effects/sensitivity.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/statics/equilibrium_state.h"

namespace kinetostat::vjm {
namespace {

using spatial::Vector6;

const Spring& find_spring(const Manipulator& manipulator, const SpringParameter& parameter) {
  const Chain& chain = manipulator.chains().at(parameter.chain);
  const auto found = std::find_if(chain.springs().begin(), chain.springs().end(),
                                  [&](const Spring& s) { return s.name == parameter.spring; });
  if (found == chain.springs().end())
    throw std::invalid_argument(
        fmt::format("chain '{}' has no spring '{}'", chain.name(), parameter.spring));
  return *found;
}

}  // namespace

void EquationChange::add(std::size_t chain, const ChainColumns& columns, Eigen::Index column,
                         double factor) {
  OfChain& change = chains[chain];
  change.force += factor * columns.force().col(column);
  change.drive += factor * columns.drive().col(column);
  change.end += factor * columns.end().col(column);
  change.origin += factor * columns.origin().col(column);
}

EquilibriumDerivatives::EquilibriumDerivatives(EquilibriumSystem& system, const Load& load,
                                               const SystemState& state)
    : system_(system), gravity_(load.gravity * system.manipulator().gravity()) {
  system.set(state, load);
  system.linearise(false);
}

ChainState EquilibriumDerivatives::chain(std::size_t index) const {
  const ChainEquations& equations = system_.chains()[index];
  return {.chain = system_.manipulator().chains()[index],
          .x = equations.coordinates(),
          .deflection = equations.deflection(),
          .travel = equations.travel(),
          .kinematics = equations.kinematics(),
          .origin = equations.origin(),
          .gravity = gravity_,
          .loads = equations.loads()};
}

EquationChange EquilibriumDerivatives::no_change() const {
  EquationChange change;
  for (const Chain& chain : system_.manipulator().chains())
    change.chains.push_back(
        {Eigen::VectorXd::Zero(chain.size()), Eigen::VectorXd::Zero(chain.size())});
  return change;
}

void EquilibriumDerivatives::add_log_stiffness(const SpringParameter& parameter,
                                               EquationChange& change) const {
  const Spring& spring = find_spring(system_.manipulator(), parameter);
  const Eigen::VectorXd force = system_.chains()[parameter.chain].force_by_log_stiffness(spring);
  change.chains[parameter.chain].force += force;
  change.chains[parameter.chain].drive += force;
}

StateDerivative EquilibriumDerivatives::solve(const EquationChange& change,
                                              const std::vector<std::size_t>& chains) const {
  const Vector6 twist = system_.scale().twist(), wrench = system_.scale().wrench();
  SystemVector right = system_.zero();
  right.bodies.head<6>() = wrench.cwiseProduct(change.platform_wrench);
  for (std::size_t c = 0; c < change.chains.size(); ++c) {
    right.coordinates[c] = -system_.chains()[c].gather_force(change.chains[c].force);
    right.wrenches[c] = -twist.cwiseProduct(change.chains[c].end);
    if (const int from = system_.manipulator().span(c).from; from != Span::base)
      right.bodies.segment<6>(6 * from) += wrench.cwiseProduct(change.chains[c].origin);
  }
  SystemVector solution;
  system_.solve_bodies(right, solution);
  StateDerivative derivative{.platform = solution.bodies.head<6>().cwiseQuotient(twist),
                             .coordinates = {}};
  if (!chains.empty()) derivative.coordinates.resize(change.chains.size());
  for (const std::size_t c : chains) {
    system_.complete(c, right, solution);
    derivative.coordinates[c] = system_.chains()[c].full_increment(solution.coordinates[c]);
  }
  return derivative;
}

Matrix6X displacement_by_log_stiffness(const Manipulator& manipulator, const Posture& posture,
                                       const Load& load, const Equilibrium& equilibrium,
                                       const std::vector<SpringParameter>& parameters) {
  EquilibriumSystem system(manipulator, posture);
  const EquilibriumDerivatives equations(system, load, state_of(equilibrium));
  Matrix6X derivatives(6, static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    EquationChange change = equations.no_change();
    equations.add_log_stiffness(parameters[p], change);
    derivatives.col(static_cast<Eigen::Index>(p)) = equations.solve(change).platform;
  }
  return derivatives;
}

}  // namespace kinetostat::vjm
