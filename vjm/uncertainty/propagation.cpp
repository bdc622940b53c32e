#include "kinetostat/vjm/uncertainty/propagation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/parallel.h"

namespace kinetostat::vjm {
namespace {

constexpr double step = 3e-4;  // of a standard uncertainty

Eigen::VectorXd estimates_of(const std::vector<UncertaintySource>& sources) {
  Eigen::VectorXd estimates(static_cast<Eigen::Index>(sources.size()));
  for (std::size_t i = 0; i < sources.size(); ++i)
    estimates[static_cast<Eigen::Index>(i)] = sources[i].estimate;
  return estimates;
}

// The values of one source that are compared.
struct Difference {
  double below, above;
};

Difference difference(const UncertaintySource& source) {
  const double h = step * source.deviation;
  return {std::clamp(source.estimate - h, source.lower, source.upper),
          std::clamp(source.estimate + h, source.lower, source.upper)};
}

// The robot at the estimates, then with each source below and above.
std::vector<Robot> compared_robots(const Robot& robot) {
  const Eigen::VectorXd estimates = estimates_of(robot.sources);
  std::vector<Robot> robots{with_values(robot, estimates)};
  for (std::size_t i = 0; i < robot.sources.size(); ++i) {
    const Difference at = difference(robot.sources[i]);
    for (const double value : {at.below, at.above}) {
      Eigen::VectorXd values = estimates;
      values[static_cast<Eigen::Index>(i)] = value;
      robots.push_back(with_values(robot, values));
    }
  }
  return robots;
}

const Eigen::VectorXd& found(const std::optional<Eigen::VectorXd>& numbers,
                             const std::string& where) {
  if (!numbers)
    throw common::NoConvergence("the uncertainty cannot be computed: no equilibrium was found " +
                                where);
  return *numbers;
}

}  // namespace

double Propagation::deviation(Eigen::Index number) const {
  const Eigen::RowVectorXd p = parts.row(number);
  const double variance = (p * correlation).dot(p);
  return variance < 0 ? 0 : std::sqrt(variance);
}

bool Propagation::is_uncertain(Eigen::Index number) const {
  constexpr double rounding = 1e-9;
  return deviation(number) > rounding * std::abs(estimate[number]);
}

Eigen::VectorXd Propagation::shares(Eigen::Index number) const {
  if (!is_uncertain(number)) return Eigen::VectorXd::Zero(parts.cols());
  const Eigen::VectorXd p = parts.row(number).transpose();
  const Eigen::VectorXd shares = p.cwiseProduct(correlation * p);
  const double sum = shares.sum();
  if (!std::isfinite(sum)) return Eigen::VectorXd::Zero(p.size());
  return shares / sum;
}

Eigen::VectorXd Propagation::mean_shares(Eigen::Index first, Eigen::Index count) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(parts.cols());
  for (Eigen::Index k = first; k < first + count; ++k) sum += shares(k);
  return sum.sum() > 0 ? Eigen::VectorXd(sum / sum.sum()) : sum;
}

Eigen::MatrixXd Propagation::covariance() const { return parts * correlation * parts.transpose(); }

Propagation propagate(const Robot& robot, const Computation& compute, int threads,
                      common::Progress& progress) {
  const std::vector<Robot> robots = compared_robots(robot);
  std::vector<std::optional<Eigen::VectorXd>> numbers(robots.size());
  common::parallel_for(robots.size(), threads, "uncertainty", progress,
                       [&](std::size_t i) { numbers[i] = compute(robots[i]); });
  Propagation result{.sources = robot.sources,
                     .value = found(compute(robot), "for the robot itself"),
                     .estimate = found(numbers[0], "at the estimates of what is uncertain"),
                     .parts = {},
                     .correlation = robot.correlation};
  result.parts.resize(result.estimate.size(), robot.correlation.cols());
  for (std::size_t i = 0; i < robot.sources.size(); ++i) {
    const UncertaintySource& source = robot.sources[i];
    const Difference at = difference(source);
    const std::string where = fmt::format("beside the estimate of the {}", source.name);
    result.parts.col(static_cast<Eigen::Index>(i)) =
        (found(numbers[2 * i + 2], where) - found(numbers[2 * i + 1], where)) *
        (source.deviation / (at.above - at.below));
  }
  return result;
}

}  // namespace kinetostat::vjm
