// Uncertain results of manipulators, for programs.
#pragma once

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/uncertainty/draws.h"

namespace kinetostat::report {

/// One of the numbers: `value` of the file's robot, `estimate`, `expanded_uncertainty` to first
/// order; with draws their `mean`, `standard_deviation` and the `interval` that holds 95 % of them.
io::Json number_json(const vjm::Uncertainty& uncertainty, Eigen::Index number);
/// What each source has in a number, the largest first: `source`, `kind`, its `estimate` and
/// `standard_uncertainty` [SI], `part` of the number's standard uncertainty, `share` of its
/// variance.
io::Json budget_json(const vjm::Uncertainty& uncertainty, Eigen::Index number);
/// The `share` of each source in the variance of several numbers, on average.
io::Json mean_budget_json(const vjm::Uncertainty& uncertainty, Eigen::Index first,
                          Eigen::Index count);
/// `coverage_factor`, and of draws `count`, `seed` and how many `failed`.
io::Json settings_json(const vjm::Uncertainty& uncertainty);
/// Of stiffness_numbers() along `direction`: `compliance_along` with its `budget`, and expanded
/// uncertainties of all entries of `compliance` and, unless it is rigid, `stiffness`.
io::Json stiffness_json(const vjm::Uncertainty& uncertainty, const spatial::Vector3& direction);
/// Of deflection_numbers(): `moved`, `turned`, `force` and `moment` with the budgets of those that
/// are uncertain, and expanded uncertainties of `displacement` and `wrench`.
io::Json deflection_json(const vjm::Uncertainty& uncertainty);

}  // namespace kinetostat::report
