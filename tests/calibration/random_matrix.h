// Noise for tests of statistics.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "kinetostat/calibration/statistics/normal.h"

namespace kinetostat::calibration::test {

/// Standard normal numbers, column by column.
inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, std::uint64_t seed) {
  Normal normal(seed);
  Eigen::MatrixXd m(rows, cols);
  for (double& x : m.reshaped()) x = normal();
  return m;
}

}  // namespace kinetostat::calibration::test
