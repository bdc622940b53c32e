#include "kinetostat/calibration/search/max_score_test.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/common/parallel.h"

namespace kinetostat::calibration {
namespace {

constexpr std::size_t at_once = 64;  // draws, as columns of one matrix

Eigen::MatrixXd noise_of(std::size_t first, std::size_t count, Eigen::Index values,
                         std::uint64_t seed) {
  Eigen::MatrixXd noise(values, static_cast<Eigen::Index>(count));
  for (std::size_t d = 0; d < count; ++d) {
    Normal normal(seed + first + d);
    for (double& x : noise.col(static_cast<Eigen::Index>(d))) x = normal();
  }
  return noise;
}

// `observed`: the largest one of the campaign, and where.
MaxScoreTest test_against_noise(const std::pair<double, std::size_t>& observed,
                                const LargestScore& largest, const ResidualSpace& space,
                                double level, int draws, std::uint64_t seed, int threads) {
  MaxScoreTest result{.draws = draws};
  std::tie(result.largest, result.where) = observed;
  std::vector<double> simulated(static_cast<std::size_t>(draws));
  common::Progress silent;
  const std::size_t blocks = (simulated.size() + at_once - 1) / at_once;
  common::parallel_for(blocks, threads, "", silent, [&](std::size_t block) {
    const std::size_t first = block * at_once;
    const std::size_t count = std::min(at_once, simulated.size() - first);
    const auto scores =
        largest(space.left_of(noise_of(first, count, space.residual().size(), seed)));
    for (std::size_t d = first; d < first + count; ++d) simulated[d] = scores[d - first].first;
  });
  std::sort(simulated.begin(), simulated.end());
  const auto above =
      simulated.end() - std::lower_bound(simulated.begin(), simulated.end(), result.largest);
  result.p_value = (1.0 + static_cast<double>(above)) / (1.0 + draws);
  const auto rank = static_cast<std::size_t>(
      std::min<double>(draws - 1, std::ceil((1 - level) * (draws + 1)) - 1));
  result.critical = simulated[rank];
  return result;
}

}  // namespace

MaxScoreTest max_score_test(const LargestScore& largest, const ResidualSpace& space, double level,
                            int draws, std::uint64_t seed, int threads) {
  return test_against_noise(largest(space.residual()).front(), largest, space, level, draws, seed,
                            threads);
}

MaxScoreTest max_score_test(const Screen& screen, const ResidualSpace& space, double level,
                            int draws, std::uint64_t seed, int threads) {
  return test_against_noise(
      screen.largest_of_chosen(space.residual()),
      [&](const Eigen::MatrixXd& residuals) { return screen.largest_significance(residuals); },
      space, level, draws, seed, threads);
}

}  // namespace kinetostat::calibration
