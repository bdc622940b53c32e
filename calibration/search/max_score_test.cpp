#include "kinetostat/calibration/search/max_score_test.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/common/parallel.h"

namespace kinetostat::calibration {
namespace {

std::pair<double, std::size_t> largest_significance(const Screen& screen,
                                                    const Eigen::VectorXd& residual) {
  std::pair<double, std::size_t> largest{0, 0};
  for (std::size_t i = 0; i < screen.size(); ++i) {
    const double significance = screen.significance(screen.score(i, residual), residual);
    if (significance > largest.first) largest = {significance, i};
  }
  return largest;
}

}  // namespace

MaxScoreTest max_score_test(const LargestScore& largest, const ResidualSpace& space, double level,
                            int draws, std::uint64_t seed, int threads) {
  MaxScoreTest result{.draws = draws};
  std::tie(result.largest, result.where) = largest(space.residual());
  std::vector<double> simulated(static_cast<std::size_t>(draws));
  common::Progress silent;
  common::parallel_for(simulated.size(), threads, "", silent, [&](std::size_t d) {
    Normal normal(seed + d);
    Eigen::VectorXd noise(space.residual().size());
    for (double& x : noise) x = normal();
    simulated[d] = largest(space.left_of(noise)).first;
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

MaxScoreTest max_score_test(const Screen& screen, const ResidualSpace& space, double level,
                            int draws, std::uint64_t seed, int threads) {
  return max_score_test(
      [&](const Eigen::VectorXd& residual) { return largest_significance(screen, residual); },
      space, level, draws, seed, threads);
}

}  // namespace kinetostat::calibration
