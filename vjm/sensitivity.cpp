#include "kinetostat/vjm/sensitivity.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/equilibrium_state.h"

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

struct EquilibriumDerivatives::System {
  System(const Manipulator& of, const Posture& posture, const Load& load)
      : manipulator(of), gravity(load.gravity * of.gravity()), equations(of, posture) {}

  const Manipulator& manipulator;
  spatial::Vector3 gravity;
  EquilibriumSystem equations;
};

EquilibriumDerivatives::EquilibriumDerivatives(const Manipulator& manipulator,
                                               const Posture& posture, const Load& load,
                                               const SystemState& state)
    : system_(std::make_unique<System>(manipulator, posture, load)) {
  system_->equations.set(state, load);
  system_->equations.linearise(false);
}

EquilibriumDerivatives::~EquilibriumDerivatives() = default;

ChainState EquilibriumDerivatives::chain(std::size_t index) const {
  const ChainEquations& equations = system_->equations.chains()[index];
  return {.chain = system_->manipulator.chains()[index],
          .x = equations.coordinates(),
          .deflection = equations.deflection(),
          .travel = equations.travel(),
          .kinematics = equations.kinematics(),
          .origin = equations.origin(),
          .gravity = system_->gravity,
          .loads = equations.loads()};
}

EquationChange EquilibriumDerivatives::no_change() const {
  EquationChange change;
  for (const Chain& chain : system_->manipulator.chains())
    change.chains.push_back(
        {Eigen::VectorXd::Zero(chain.size()), Eigen::VectorXd::Zero(chain.size())});
  return change;
}

void EquilibriumDerivatives::add_log_stiffness(const SpringParameter& parameter,
                                               EquationChange& change) const {
  const Spring& spring = find_spring(system_->manipulator, parameter);
  const Eigen::VectorXd force =
      system_->equations.chains()[parameter.chain].force_by_log_stiffness(spring);
  change.chains[parameter.chain].force += force;
  change.chains[parameter.chain].drive += force;
}

StateDerivative EquilibriumDerivatives::solve(const EquationChange& change) const {
  const EquilibriumSystem& equations = system_->equations;
  const Vector6 twist = equations.scale().twist(), wrench = equations.scale().wrench();
  SystemVector right = equations.zero();
  right.bodies.head<6>() = wrench.cwiseProduct(change.platform_wrench);
  for (std::size_t c = 0; c < change.chains.size(); ++c) {
    right.coordinates[c] = -equations.chains()[c].gather_force(change.chains[c].force);
    right.wrenches[c] = -twist.cwiseProduct(change.chains[c].end);
    if (const int from = system_->manipulator.span(c).from; from != Span::base)
      right.bodies.segment<6>(6 * from) += wrench.cwiseProduct(change.chains[c].origin);
  }
  const SystemVector solution = equations.solve(right);
  StateDerivative derivative{.platform = solution.bodies.head<6>().cwiseQuotient(twist),
                             .coordinates = {}};
  for (std::size_t c = 0; c < change.chains.size(); ++c)
    derivative.coordinates.push_back(equations.chains()[c].full_increment(solution.coordinates[c]));
  return derivative;
}

Matrix6X displacement_by_log_stiffness(const Manipulator& manipulator, const Posture& posture,
                                       const Load& load, const Equilibrium& equilibrium,
                                       const std::vector<SpringParameter>& parameters) {
  const EquilibriumDerivatives equations(manipulator, posture, load, state_of(equilibrium));
  Matrix6X derivatives(6, static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    EquationChange change = equations.no_change();
    equations.add_log_stiffness(parameters[p], change);
    derivatives.col(static_cast<Eigen::Index>(p)) = equations.solve(change).platform;
  }
  return derivatives;
}

}  // namespace kinetostat::vjm
