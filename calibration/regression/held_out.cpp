#include "kinetostat/calibration/regression/held_out.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <Eigen/Cholesky>

#include "kinetostat/calibration/sensors/weight.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t fewest_groups = 4;

template <class Key, class KeyOf>
HeldOutGroups grouped(const std::vector<Value>& values, std::string what, const KeyOf& key_of) {
  std::map<Key, std::vector<Index>> by_key;
  for (std::size_t i = 0; i < values.size(); ++i)
    by_key[key_of(values[i])].push_back(static_cast<Index>(i));
  HeldOutGroups groups{.members = {}, .what = std::move(what)};
  for (auto& [key, members] : by_key) groups.members.push_back(std::move(members));
  return groups;
}

}  // namespace

HeldOutGroups held_out_groups(const Campaign& campaign, const std::vector<Value>& values) {
  const auto reading = [&](const Value& v) -> const Reading& {
    return campaign.readings[v.reading];
  };
  HeldOutGroups groups = grouped<std::size_t>(
      values, "configurations", [&](const Value& v) { return reading(v).configuration; });
  if (groups.members.size() >= fewest_groups) return groups;
  groups = grouped<std::pair<std::size_t, std::string>>(values, "load cycles", [&](const Value& v) {
    return std::pair(reading(v).session, reading(v).cycle);
  });
  if (groups.members.size() >= fewest_groups) return groups;
  groups = grouped<std::array<double, 9>>(values, "loads", [&](const Value& v) {
    const vjm::Load& load = reading(v).load;
    return std::array{static_cast<double>(reading(v).configuration),
                      load.force.x(),
                      load.force.y(),
                      load.force.z(),
                      load.moment.x(),
                      load.moment.y(),
                      load.moment.z(),
                      force_at_nodes(load).norm(),
                      load_in_joints(load).norm()};
  });
  if (groups.members.size() >= fewest_groups) return groups;
  return grouped<std::size_t>(values, "readings", [](const Value& v) { return v.reading; });
}

double HeldOut::total() const { return std::accumulate(log_score.begin(), log_score.end(), 0.0); }

void hold_bounds(const BaseFit& fit, VectorXd& information) {
  constexpr double firmly = 1e12;  // beside what the readings say
  for (std::size_t k = 0; k < fit.parameters.size(); ++k)
    if (const auto i = static_cast<Index>(k); fit.parameters[k].hit != BoundHit::none)
      information[i] += firmly * fit.at.jacobian.col(i).squaredNorm();
}

VectorXd prior_information(const BaseFit& fit) {
  VectorXd information = VectorXd::Zero(fit.at.jacobian.cols());
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    const Parameter& parameter = fit.parameters[k].parameter;
    const double range = parameter.upper - parameter.lower;
    if (parameter.prior)
      information[static_cast<Index>(k)] = 1 / std::pow(parameter.prior->deviation, 2);
    else if (range > 0)
      information[static_cast<Index>(k)] = 12 / (range * range);
  }
  hold_bounds(fit, information);
  return information;
}

HeldOut held_out(const Linearisation& fit, const VectorXd& information, const HeldOutGroups& groups,
                 double exponent) {
  const MatrixXd& j = fit.jacobian;
  const Index n = j.cols();
  // Columns of unit length, so that units do not matter; what nothing tells has no part.
  VectorXd scale(n);
  for (Index k = 0; k < n; ++k) {
    const double length = std::sqrt(exponent * j.col(k).squaredNorm() + information[k]);
    scale[k] = length > 1e-150 ? 1 / length : 0;  // whose square is a number
  }
  MatrixXd a = exponent * scale.asDiagonal() * (j.transpose() * j) * scale.asDiagonal();
  a.diagonal() += information.cwiseProduct(scale.cwiseAbs2());
  a.diagonal().array() += 1e-12;
  const Eigen::LDLT<MatrixXd> factor(a);
  HeldOut result;
  result.error = VectorXd::Zero(fit.residual.size());
  for (const std::vector<Index>& group : groups.members) {
    const auto count = static_cast<Index>(group.size());
    const MatrixXd part = j(group, Eigen::all) * scale.asDiagonal();
    const VectorXd residual = -fit.residual(group);
    MatrixXd rest = -exponent * part * factor.solve(part.transpose());
    rest.diagonal().array() += 1;  // I - H
    // A group alone may determine an unknown; nothing is then predicted in that direction, as where
    // the others predict it a hundred times worse than it is read: a frame of two postures.
    const spatial::SymmetricEigen eigen = spatial::symmetric_eigen(0.5 * (rest + rest.transpose()));
    const VectorXd values = eigen.values.cwiseMax(1e-9);
    const VectorXd along = eigen.vectors.transpose() * residual;
    result.log_score.push_back(-0.5 * exponent * along.cwiseAbs2().cwiseQuotient(values).sum() +
                               0.5 * values.array().log().sum() +
                               0.5 * static_cast<double>(count) *
                                   std::log(exponent / (2 * std::numbers::pi)));
    constexpr double predicted = 1e-4;  // variance of the noise, over that of the prediction
    const VectorXd errors =
        eigen.vectors *
        along.cwiseQuotient((values.array() < predicted).select(1, values.array()).matrix());
    for (Index k = 0; k < count; ++k) result.error[group[static_cast<std::size_t>(k)]] = errors[k];
  }
  return result;
}

}  // namespace kinetostat::calibration
