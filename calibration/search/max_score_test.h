// Detection threshold: a max-statistic test (family-wise). Many candidates are tried, so the
// largest of all scores is compared with the largest that noise alone gives.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

inline constexpr double significance_of_pairs = 0.01;  // beside that of single effects
/// Up to this chance of a false alarm candidates are fitted: the evidence decides what is found.
inline constexpr double worth_a_look = 0.1;

struct MaxScoreTest {
  double largest = 0;     // the score
  std::size_t where = 0;  // which it is
  /// Chance of a false alarm: share of campaigns with nothing missing that have as large a score.
  double p_value = 1;
  double critical = 0;  // score that `level` of them exceed
  int draws = 0;
};

/// The largest of some scores, and which it is: of every column of residuals.
using LargestScore =
    std::function<std::vector<std::pair<double, std::size_t>>(const Eigen::MatrixXd&)>;

/// Parametric bootstrap of the largest score T(r) = max_i -ln p_i(r), in the linear model about the
/// base fit:
///
///   T_d = T(N z_d),   z_d ~ N(0, I),   d = 1 ... D
///   p_value  = (1 + #{d: T_d >= T(r)}) / (1 + D)
///   critical = T_(k), the k-th smallest of the T_d,   k = ceil((1 - level) (D + 1))
///
/// r: residual of the campaign in `space`; N: projector of `space`, which fits each simulated
/// campaign; D = `draws`. The test holds the family-wise error whatever the dimensions, the
/// correlations and the shapes of the candidates. The result is the same for any number of threads.
MaxScoreTest max_score_test(const LargestScore& largest, const ResidualSpace& space, double level,
                            int draws, std::uint64_t seed, int threads);
/// The test of the significance of all signatures, Screen::significance().
MaxScoreTest max_score_test(const Screen& screen, const ResidualSpace& space, double level,
                            int draws, std::uint64_t seed, int threads);

}  // namespace kinetostat::calibration
