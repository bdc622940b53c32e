// The numbers that a verdict rests on.
#include <fmt/format.h>

#include "kinetostat/calibration/diagnosis/decision.h"

#include "tables.h"

namespace kinetostat::theory {

std::string decision_rules() {
  std::vector<std::vector<std::string>> rows;
  for (const calibration::DescribedRule& rule : calibration::described())
    rows.push_back(
        {rule.name, fmt::format("{:g}", rule.value), rule.unit, rule.source, rule.sensitivity});
  return markdown({"rule", "value", "unit", "source", "when it is halved or doubled"}, rows);
}

}  // namespace kinetostat::theory
