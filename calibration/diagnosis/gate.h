// Is anything there at all? Many candidates are tried, so the largest of all scores is compared
// with the largest that noise alone gives.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

inline constexpr double significance_of_pairs = 0.01;  // beside that of single effects

struct Gate {
  double largest = 0;     // the score
  std::size_t where = 0;  // which it is
  double p_value = 1;     // share of campaigns with nothing missing that have as large a one
  double critical = 0;    // score that `level` of them exceed
  int draws = 0;
};

/// The largest of some scores of a residual, and which it is.
using LargestScore = std::function<std::pair<double, std::size_t>(const Eigen::VectorXd&)>;

/// Parametric bootstrap of the largest score, in the linear model about the base fit:
/// the fit of each simulated campaign is its projection. Holds the family-wise error whatever the
/// dimensions, the correlations and the shapes of the candidates. The same for any number of
/// threads.
Gate gate_of(const LargestScore& largest, const ResidualSpace& space, double level, int draws,
             std::uint64_t seed, int threads);
/// Of the surprise of all signatures.
Gate gate(const Screen& screen, const ResidualSpace& space, double level, int draws,
          std::uint64_t seed, int threads);

}  // namespace kinetostat::calibration
