#include "kinetostat/calibration/search/outliers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "kinetostat/calibration/statistics/residual_space.h"
#include "kinetostat/calibration/statistics/robust_residual.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double bend = 2;
constexpr int rounds = 8;
constexpr std::size_t most_effects = 3;
constexpr std::size_t most_tried = 24;  // in one round, those with the largest scores

// -log of the density of an outlier over that of no deviation at all.
const double cost_of_outlier = -std::log(0.01 / 200 * std::sqrt(2 * std::numbers::pi));

double cost_of(const VectorXd& left) {
  return (left.array().square() / 2).min(cost_of_outlier).sum();
}

// An effect with what it explains of a residual that no single value rules.
struct Scored {
  std::size_t effect = 0;
  Index rank = 0;
  double explained = 0;
};

std::vector<Scored> most_explaining(const VectorXd& left, const MatrixXd& known,
                                    std::size_t effects, const EffectColumns& effect) {
  const ResidualSpace space(left.cwiseMax(-bend).cwiseMin(bend), known);
  std::vector<Scored> scored;
  space.for_each_left(effects, effect, [&](std::size_t e, const MatrixXd&, const MatrixXd& left) {
    const MatrixXd span = span_of(left, least_visible);
    if (span.cols() > 0)
      scored.push_back({e, span.cols(), (span.transpose() * space.residual()).squaredNorm()});
  });
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) {
    return a.explained - static_cast<double>(a.rank) > b.explained - static_cast<double>(b.rank);
  });
  if (scored.size() > most_tried) scored.resize(most_tried);
  return scored;
}

}  // namespace

std::vector<std::size_t> outliers(const VectorXd& residual, const MatrixXd& fitted,
                                  std::size_t effects, const EffectColumns& effect,
                                  const std::vector<EffectEntry>& entries) {
  const double choice = std::log(static_cast<double>(std::max<std::size_t>(1, effects)));
  const double of_column = std::log(static_cast<double>(std::max<Index>(2, residual.size()))) / 2;
  MatrixXd present(residual.size(), 0);
  std::set<std::size_t> entered;
  RobustResidual now = robust_residual(residual, fitted, present, bend, rounds);
  for (std::size_t added = 0; added < most_effects; ++added) {
    double least = cost_of(now.left);
    std::optional<std::size_t> best;
    RobustResidual with_best;
    for (const Scored& scored :
         most_explaining(now.left, beside(fitted, present), effects, effect)) {
      const EffectEntry entry = entries.empty() ? EffectEntry() : entries[scored.effect];
      if (entry.beside && !entered.contains(*entry.beside)) continue;
      RobustResidual with =
          robust_residual(residual, fitted, beside(present, effect(scored.effect)), bend, rounds);
      const double cost = cost_of(with.left) + choice + entry.handicap +
                          of_column * static_cast<double>(scored.rank);
      if (cost >= least) continue;
      least = cost;
      best = scored.effect;
      with_best = std::move(with);
    }
    if (!best) break;
    present = beside(present, effect(*best));
    entered.insert(*best);
    now = std::move(with_best);
  }
  std::vector<std::size_t> found;
  for (Index i = 0; i < residual.size(); ++i)
    if (std::abs(now.surprise[i]) > outlying) found.push_back(static_cast<std::size_t>(i));
  return found;
}

}  // namespace kinetostat::calibration
