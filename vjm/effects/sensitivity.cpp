#include "kinetostat/vjm/effects/sensitivity.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/statics/equilibrium_state.h"
#include "kinetostat/vjm/statics/newton_matrix.h"

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
  for (const PlaceMotion& moved : columns.motions(column))
    change.motions.push_back({moved.joints, moved.in_front, moved.point, factor * moved.motion});
}

EquilibriumDerivatives::EquilibriumDerivatives(const EquilibriumResiduals& at)
    : at_(at), matrix_(std::make_unique<NewtonMatrix>(at, false)) {}
EquilibriumDerivatives::EquilibriumDerivatives(const EquilibriumResiduals& at, NewtonMatrix matrix)
    : at_(at) {
  matrix.renew(at);
  matrix_ = std::make_unique<const NewtonMatrix>(std::move(matrix));
}
EquilibriumDerivatives::EquilibriumDerivatives(EquilibriumDerivatives&&) noexcept = default;
EquilibriumDerivatives::~EquilibriumDerivatives() = default;

ChainState chain_state(const EquilibriumResiduals& at, std::size_t index) {
  const ChainResiduals& chain = at.chains()[index];
  return {.chain = chain.equations().chain(),
          .x = chain.coordinates(),
          .deflection = chain.deflection(),
          .travel = chain.travel(),
          .kinematics = chain.kinematics(),
          .origin = chain.origin(),
          .gravity = at.load().gravity * at.system().manipulator().gravity(),
          .loads = chain.loads()};
}

void EquilibriumDerivatives::expect(std::size_t solutions) const {
  constexpr std::size_t motions = 6;  // of the platform
  if (solutions > motions) matrix_->prepare_bodies();
}

EquationChange EquilibriumDerivatives::no_change() const {
  EquationChange change;
  make_none(change);
  return change;
}

void EquilibriumDerivatives::make_none(EquationChange& change) const {
  const std::vector<Chain>& chains = at_.system().manipulator().chains();
  change.platform_wrench.setZero();
  change.chains.resize(chains.size());
  for (std::size_t c = 0; c < chains.size(); ++c) {
    EquationChange::OfChain& of_chain = change.chains[c];
    of_chain.force.setZero(chains[c].size());
    of_chain.drive.setZero(chains[c].size());
    of_chain.end.setZero();
    of_chain.origin.setZero();
    of_chain.motions.clear();
  }
}

void EquilibriumDerivatives::add_log_stiffness(const SpringParameter& parameter,
                                               EquationChange& change) const {
  const Spring& spring = find_spring(at_.system().manipulator(), parameter);
  const ChainResiduals& chain = at_.chains()[parameter.chain];
  EquationChange::OfChain& of_chain = change.chains[parameter.chain];
  chain.add_force_by_log_stiffness(spring, false, of_chain.force);
  chain.add_force_by_log_stiffness(spring, true, of_chain.drive);
}

StateDerivative EquilibriumDerivatives::solve(const EquationChange& change,
                                              const std::vector<std::size_t>& chains) const {
  StateDerivative derivative;
  solve(change, chains, derivative);
  return derivative;
}

void EquilibriumDerivatives::solve(const EquationChange& change,
                                   const std::vector<std::size_t>& chains,
                                   StateDerivative& derivative) const {
  const EquilibriumSystem& system = at_.system();
  const Vector6 twist = system.scale().twist(), wrench = system.scale().wrench();
  auto& [right, solution] = matrix_->scratch();
  system.make_zero(right);
  right.bodies.head<6>() = wrench.cwiseProduct(change.platform_wrench);
  for (std::size_t c = 0; c < change.chains.size(); ++c) {
    system.chains()[c].gather_force(change.chains[c].force, right.coordinates[c]);
    right.coordinates[c] *= -1;
    right.wrenches[c] = -twist.cwiseProduct(change.chains[c].end);
    if (const Eigen::Index from = system.manipulator().span(c).from; from != Span::base)
      right.bodies.segment<6>(6 * from) += wrench.cwiseProduct(change.chains[c].origin);
  }
  matrix_->solve_bodies(right, solution);
  derivative.bodies.resize(solution.bodies.size());
  for (Eigen::Index row = 0; row < derivative.bodies.size(); row += 6)
    derivative.bodies.segment<6>(row) = solution.bodies.segment<6>(row).cwiseQuotient(twist);
  derivative.platform = derivative.bodies.head<6>();
  if (!chains.empty()) derivative.coordinates.resize(change.chains.size());
  for (const std::size_t c : chains) {
    matrix_->complete(c, right, solution);
    derivative.coordinates[c] = system.chains()[c].full_increment(solution.coordinates[c]);
  }
}

Matrix6X displacement_by_log_stiffness(const Manipulator& manipulator, const Posture& posture,
                                       const Load& load, const Equilibrium& equilibrium,
                                       const std::vector<SpringParameter>& parameters) {
  const EquilibriumSystem system(manipulator, posture);
  const EquilibriumResiduals at(system, state_of(equilibrium), load);
  const EquilibriumDerivatives equations(at);
  Matrix6X derivatives(6, static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    EquationChange change = equations.no_change();
    equations.add_log_stiffness(parameters[p], change);
    derivatives.col(static_cast<Eigen::Index>(p)) = equations.solve(change).platform;
  }
  return derivatives;
}

}  // namespace kinetostat::vjm
