#include "kinetostat/vjm/uncertainty/draws.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <random>

#include <Eigen/Eigenvalues>
#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/parallel.h"

namespace kinetostat::vjm {
namespace {

// In (0, 1): 53 random bits.
double uniform(std::mt19937_64& engine) {
  return (static_cast<double>(engine() >> 11) + 0.5) * 0x1p-53;
}

// 0, 1, ... in some order. std::shuffle's differs from library to library.
std::vector<std::size_t> shuffled(std::size_t count, std::mt19937_64& engine) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  for (std::size_t i = count; i > 1; --i)
    std::swap(order[i - 1],
              order[static_cast<std::size_t>(uniform(engine) * static_cast<double>(i))]);
  return order;
}

// A share of probability for every source, one column a draw.
Eigen::MatrixXd hypercube(std::size_t sources, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  Eigen::MatrixXd shares(static_cast<Eigen::Index>(sources), static_cast<Eigen::Index>(count));
  for (Eigen::Index s = 0; s < shares.rows(); ++s) {
    const std::vector<std::size_t> order = shuffled(count, engine);
    for (std::size_t i = 0; i < count; ++i)
      shares(s, static_cast<Eigen::Index>(i)) =
          (static_cast<double>(order[i]) + uniform(engine)) / static_cast<double>(count);
  }
  return shares;
}

void correlate(const Eigen::MatrixXd& correlation, Eigen::MatrixXd& shares) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  const Eigen::MatrixXd root =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const boost::math::normal normal;
  constexpr double least = 1e-16;
  shares = root * shares.unaryExpr([&](double p) { return quantile(normal, p); });
  shares = shares.unaryExpr([&](double z) { return std::clamp(cdf(normal, z), least, 1 - least); });
}

std::optional<Robot> possible_robot(const Robot& robot, const Eigen::VectorXd& values) {
  try {
    return with_values(robot, values);
  } catch (const common::InputError&) {
    return std::nullopt;  // counted
  }
}

// Files are read by one thread, the robots computed by several, so many at a time.
constexpr std::size_t batch = 256;

}  // namespace

bool have_other_postures(const Robot& robot) {
  return std::any_of(
      robot.sources.begin(), robot.sources.end(),
      [](const UncertaintySource& source) { return source.kind == SourceKind::length; });
}

Eigen::MatrixXd drawn_values(const Robot& robot, std::size_t count, std::uint64_t seed) {
  Eigen::MatrixXd shares = hypercube(robot.sources.size(), count, seed);
  if (!robot.correlation.isIdentity(0)) correlate(robot.correlation, shares);
  for (Eigen::Index s = 0; s < shares.rows(); ++s)
    for (double& share : shares.row(s))
      share = robot.sources[static_cast<std::size_t>(s)].quantile(share);
  return shares;
}

double Draws::mean(Eigen::Index number) const { return numbers.row(number).mean(); }

double Draws::deviation(Eigen::Index number) const {
  const Eigen::RowVectorXd off = numbers.row(number).array() - mean(number);
  return off.size() > 1 ? std::sqrt(off.squaredNorm() / static_cast<double>(off.size() - 1)) : 0;
}

double Draws::quantile(Eigen::Index number, double p) const {
  const Eigen::RowVectorXd row = numbers.row(number);
  std::vector<double> sorted;
  std::copy_if(row.begin(), row.end(), std::back_inserter(sorted),
               [](double x) { return !std::isnan(x); });
  if (sorted.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(sorted.begin(), sorted.end());
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
}

DrawnNumbers compute_draws(const Robot& robot, const Computation& compute, std::size_t count,
                           std::uint64_t seed, const std::vector<std::size_t>& wanted, int threads,
                           common::Progress& progress) {
  const Eigen::MatrixXd values = drawn_values(robot, count, seed);
  DrawnNumbers computed;
  for (std::size_t first = 0; first < wanted.size(); first += batch) {
    progress.report("draws", static_cast<double>(first) / static_cast<double>(wanted.size()));
    std::vector<std::optional<Robot>> robots;
    for (std::size_t i = first; i < std::min(first + batch, wanted.size()); ++i)
      robots.push_back(possible_robot(robot, values.col(static_cast<Eigen::Index>(wanted[i]))));
    std::vector<std::optional<Eigen::VectorXd>> numbers(robots.size());
    common::SilentPart part(progress);
    common::parallel_for(robots.size(), threads, "draws", part, [&](std::size_t i) {
      if (robots[i]) numbers[i] = compute(*robots[i]);
    });
    for (std::size_t i = 0; i < numbers.size(); ++i)
      computed[wanted[first + i]] = std::move(numbers[i]);
  }
  return computed;
}

Draws draws_of(std::size_t count, std::uint64_t seed, const DrawnNumbers& all) {
  std::vector<const Eigen::VectorXd*> computed;
  for (const auto& [number, of_draw] : all)
    if (of_draw) computed.push_back(&*of_draw);
  if (2 * computed.size() < count)
    throw common::NoConvergence(
        fmt::format("only {} of {} robots drawn stand in an equilibrium", computed.size(), count));
  Draws draws{.count = count, .seed = seed, .numbers = {}};
  draws.numbers.resize(computed[0]->size(), static_cast<Eigen::Index>(computed.size()));
  for (std::size_t i = 0; i < computed.size(); ++i)
    draws.numbers.col(static_cast<Eigen::Index>(i)) = *computed[i];
  return draws;
}

Draws draw(const Robot& robot, const Computation& compute, std::size_t count, std::uint64_t seed,
           int threads, common::Progress& progress) {
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  return draws_of(count, seed, compute_draws(robot, compute, count, seed, all, threads, progress));
}

}  // namespace kinetostat::vjm
