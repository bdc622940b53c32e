#include "kinetostat/calibration/comparison/waterfall.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "kinetostat/calibration/campaign/datum.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int resamples = 1000;

double root_mean_square(double sum, Index count) {
  return count == 0 ? std::numeric_limits<double>::quiet_NaN()
                    : std::sqrt(sum / static_cast<double>(count));
}

void add_physical(const VectorXd& whitened, const Campaign& campaign,
                  const std::vector<Value>& values, const Noise& noise, WaterfallStage& stage) {
  Eigen::MatrixXd error = whitened;
  SharedNoise(noise, values).restore(error);
  double sums[2] = {0, 0};
  Index counts[2] = {0, 0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const spatial::Dimension& dimension = campaign.component(values[i].component).dimension;
    if (dimension != spatial::dimension::length && dimension != spatial::dimension::angle) continue;
    const int kind = dimension == spatial::dimension::angle ? 1 : 0;
    const double sigma = noise.sigma[values[i].reading][values[i].component];
    sums[kind] += std::pow(error(static_cast<Index>(i), 0) * sigma, 2);
    ++counts[kind];
  }
  stage.translation = root_mean_square(sums[0], counts[0]);
  stage.rotation = root_mean_square(sums[1], counts[1]);
}

}  // namespace

WaterfallStage waterfall_stage(const std::string& name, const BaseFit& fit,
                               const Campaign& campaign, const std::vector<Value>& values,
                               const Noise& noise, const HeldOutGroups& groups,
                               std::uint64_t seed) {
  return waterfall_stage(name, held_out(fit.at, prior_information(fit), groups, 1).error, campaign,
                         values, noise, groups, seed);
}

WaterfallStage waterfall_stage(const std::string& name, const VectorXd& error,
                               const Campaign& campaign, const std::vector<Value>& values,
                               const Noise& noise, const HeldOutGroups& groups,
                               std::uint64_t seed) {
  WaterfallStage stage{.name = name};
  stage.whitened = root_mean_square(error.squaredNorm(), error.size());
  add_physical(error, campaign, values, noise, stage);
  std::vector<double> sums;
  std::vector<Index> counts;
  for (const std::vector<Index>& group : groups.members) {
    sums.push_back(error(group).squaredNorm());
    counts.push_back(static_cast<Index>(group.size()));
  }
  std::mt19937_64 engine(seed);
  std::vector<double> resampled;
  for (int r = 0; r < resamples; ++r) {
    double sum = 0;
    Index count = 0;
    for (std::size_t g = 0; g < sums.size(); ++g) {
      const std::size_t chosen = engine() % sums.size();
      sum += sums[chosen];
      count += counts[chosen];
    }
    resampled.push_back(root_mean_square(sum, count));
  }
  std::sort(resampled.begin(), resampled.end());
  stage.lower = resampled[resamples / 40];
  stage.upper = resampled[resamples - 1 - resamples / 40];
  return stage;
}

WaterfallStage noise_floor(const Campaign& campaign, const std::vector<Value>& values,
                           const Noise& noise) {
  WaterfallStage stage{.name = "noise floor", .whitened = 1, .lower = 1, .upper = 1};
  add_physical(VectorXd::Ones(static_cast<Index>(values.size())), campaign, values, noise, stage);
  return stage;
}

}  // namespace kinetostat::calibration
