#include "kinetostat/vjm/sensitivity.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/equilibrium_state.h"

namespace kinetostat::vjm {
namespace {

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

Eigen::Matrix<double, 6, Eigen::Dynamic> displacement_by_log_stiffness(
    const Manipulator& manipulator, const Posture& posture, const Load& load,
    const Equilibrium& equilibrium, const std::vector<SpringParameter>& parameters) {
  EquilibriumSystem system(manipulator, posture);
  system.set(state_of(equilibrium), load);
  system.linearise(false);

  Eigen::Matrix<double, 6, Eigen::Dynamic> derivatives(6, parameters.size());
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const Spring& spring = find_spring(manipulator, parameters[p]);
    SystemVector right = system.zero();
    right.coordinates[parameters[p].chain] =
        -system.chains()[parameters[p].chain].unbalanced_by_log_stiffness(spring);
    derivatives.col(static_cast<Eigen::Index>(p)) =
        system.solve(right).bodies.head<6>().cwiseQuotient(system.scale().twist());
  }
  return derivatives;
}

}  // namespace kinetostat::vjm
