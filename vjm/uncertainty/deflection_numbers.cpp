#include "kinetostat/vjm/uncertainty/deflection_numbers.h"

namespace kinetostat::vjm {

std::optional<Eigen::VectorXd> deflection_numbers(const Equilibrium& e) {
  if (e.status != EquilibriumStatus::converged) return std::nullopt;
  Eigen::VectorXd numbers(DeflectionNumbers::count);
  numbers << e.displacement.translation.norm(), e.displacement.rotation.norm(),
      e.displacement.translation, e.displacement.rotation, e.wrench.force.norm(),
      e.wrench.moment.norm(), e.wrench.force, e.wrench.moment;
  return numbers;
}

}  // namespace kinetostat::vjm
