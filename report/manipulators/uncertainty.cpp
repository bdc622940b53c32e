#include "kinetostat/report/manipulators/uncertainty.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "kinetostat/vjm/uncertainty/deflection_numbers.h"
#include "kinetostat/vjm/uncertainty/stiffness_numbers.h"

namespace kinetostat::report {

using io::Json;

Json number_json(const vjm::Uncertainty& uncertainty, Eigen::Index number) {
  const vjm::Propagation& first = uncertainty.first_order;
  Json json{{"value", first.value[number]},
            {"estimate", first.estimate[number]},
            {"expanded_uncertainty", first.expanded(number)}};
  if (uncertainty.draws)
    json["draws"] = {
        {"mean", uncertainty.draws->mean(number)},
        {"standard_deviation", uncertainty.draws->deviation(number)},
        {"interval",
         {uncertainty.draws->quantile(number, 0.025), uncertainty.draws->quantile(number, 0.975)}}};
  return json;
}

namespace {

// Expanded uncertainties of 36 numbers, as the rows of a 6x6.
Json expanded_matrix(const vjm::Uncertainty& uncertainty, Eigen::Index first) {
  Eigen::Matrix<double, 6, 6> expanded;
  for (Eigen::Index k = 0; k < 36; ++k)
    expanded(k / 6, k % 6) = uncertainty.first_order.expanded(first + k);
  return io::rows(expanded);
}

// Sources, the one with the largest share first.
std::vector<Eigen::Index> by_share(const Eigen::VectorXd& shares) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(shares.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return shares[a] > shares[b]; });
  return order;
}

}  // namespace

Json budget_json(const vjm::Uncertainty& uncertainty, Eigen::Index number) {
  const vjm::Propagation& first = uncertainty.first_order;
  const Eigen::VectorXd shares = first.shares(number);
  Json budget = Json::array();
  for (const Eigen::Index i : by_share(shares)) {
    const vjm::UncertaintySource& source = first.sources[static_cast<std::size_t>(i)];
    budget.push_back({{"source", source.name},
                      {"kind", to_string(source.kind)},
                      {"estimate", source.estimate},
                      {"standard_uncertainty", source.deviation},
                      {"part", first.parts(number, i)},
                      {"share", shares[i]}});
  }
  return budget;
}

Json mean_budget_json(const vjm::Uncertainty& uncertainty, Eigen::Index first, Eigen::Index count) {
  const Eigen::VectorXd shares = uncertainty.first_order.mean_shares(first, count);
  Json budget = Json::array();
  for (const Eigen::Index i : by_share(shares)) {
    const auto& source = uncertainty.first_order.sources[static_cast<std::size_t>(i)];
    budget.push_back(
        {{"source", source.name}, {"kind", to_string(source.kind)}, {"share", shares[i]}});
  }
  return budget;
}

Json settings_json(const vjm::Uncertainty& uncertainty) {
  Json json{{"coverage_factor", vjm::coverage_factor}};
  if (uncertainty.draws)
    json["draws"] = {{"count", uncertainty.draws->count},
                     {"seed", uncertainty.draws->seed},
                     {"failed", uncertainty.draws->failed()}};
  return json;
}

Json stiffness_json(const vjm::Uncertainty& uncertainty, const spatial::Vector3& direction) {
  using Numbers = vjm::StiffnessNumbers;
  Json json = settings_json(uncertainty);
  json["direction"] = io::to_json(direction);
  json["compliance_along"] = number_json(uncertainty, Numbers::along);
  json["budget"] = budget_json(uncertainty, Numbers::along);
  json["compliance"] = expanded_matrix(uncertainty, Numbers::compliance);
  if (!uncertainty.first_order.value.segment<36>(Numbers::stiffness).isZero(0))
    json["stiffness"] = expanded_matrix(uncertainty, Numbers::stiffness);
  return json;
}

Json deflection_json(const vjm::Uncertainty& uncertainty) {
  using Numbers = vjm::DeflectionNumbers;
  const vjm::Propagation& first = uncertainty.first_order;
  Json json = settings_json(uncertainty);
  for (const auto& [name, number] :
       {std::pair("moved", Numbers::moved), std::pair("turned", Numbers::turned),
        std::pair("force", Numbers::force), std::pair("moment", Numbers::moment)}) {
    if (!first.is_uncertain(number)) continue;
    json[name] = number_json(uncertainty, number);
    json[name]["budget"] = budget_json(uncertainty, number);
  }
  for (const auto& [name, number] :
       {std::pair("displacement", Numbers::displacement), std::pair("wrench", Numbers::wrench)}) {
    json[name] = Json::array();
    for (Eigen::Index k = number; k < number + 6; ++k) json[name].push_back(first.expanded(k));
  }
  return json;
}

}  // namespace kinetostat::report
