// Is anything there at all? Many candidates are tried, so the largest of all scores is compared
// with the largest that noise alone gives.
#pragma once

#include <cstdint>
#include <vector>

#include "kinetostat/calibration/residual_space.h"

namespace kinetostat::calibration {

struct Gate {
  double largest = 0;     // surprise (Screen) of the most surprising signature
  std::size_t where = 0;  // which that is
  double p_value = 1;     // share of campaigns with nothing missing that surprise as much
  double critical = 0;    // surprise that `level` of them exceed
  int draws = 0;
};

/// Parametric bootstrap of the maximum over all signatures, in the linear model about the base fit:
/// the fit of each simulated campaign is its projection. Holds the family-wise error whatever the
/// dimensions, the correlations and the shapes of the candidates. The same for any number of
/// threads.
Gate gate(const Screen& screen, const ResidualSpace& space, double level, int draws,
          std::uint64_t seed, int threads);

}  // namespace kinetostat::calibration
