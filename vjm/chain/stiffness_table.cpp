#include "kinetostat/vjm/chain/stiffness_table.h"

#include <algorithm>
#include <stdexcept>

namespace kinetostat::vjm {

StiffnessTable::StiffnessTable(std::vector<double> commands, const std::vector<double>& stiffness)
    : commands_(std::move(commands)) {
  if (commands_.size() != stiffness.size() || commands_.size() < 2)
    throw std::invalid_argument("a table of stiffness needs two or more places, one value each");
  if (std::adjacent_find(commands_.begin(), commands_.end(),
                         [](double a, double b) { return !(a < b); }) != commands_.end())
    throw std::invalid_argument("the places of a table of stiffness ascend");
  for (const double k : stiffness) {
    if (!(k > 0)) throw std::invalid_argument("a stiffness is positive");
    compliance_.push_back(1 / k);
  }
}

double StiffnessTable::at(double command) const {
  if (command <= commands_.front()) return 1 / compliance_.front();
  if (command >= commands_.back()) return 1 / compliance_.back();
  const auto i = static_cast<std::size_t>(
      std::upper_bound(commands_.begin(), commands_.end(), command) - commands_.begin());
  const double t = (command - commands_[i - 1]) / (commands_[i] - commands_[i - 1]);
  return 1 / ((1 - t) * compliance_[i - 1] + t * compliance_[i]);
}

TabulatedStiffness::TabulatedStiffness(StiffnessTable table, double at_spring)
    : table_(std::move(table)), of_spring_(table_.at(at_spring)) {}

double TabulatedStiffness::more(const JointState& joint) const {
  return table_.at(joint.position - joint.travel) / of_spring_ - 1;
}

CoordinateLaw::Value TabulatedStiffness::at(const JointState& joint) const {
  const double more = this->more(joint), d = joint.deflection;
  return {.force = more * joint.stiffness * d,
          .tangent = more * joint.stiffness,
          .force_by_stiffness = more * d};
}

double TabulatedStiffness::energy(const JointState& joint) const {
  return more(joint) * joint.stiffness * joint.deflection * joint.deflection / 2;
}

}  // namespace kinetostat::vjm
