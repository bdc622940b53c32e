#include "kinetostat/vjm/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace kinetostat::vjm {

Stability stability_of(const Eigen::MatrixXd& energy_hessian, double tolerance) {
  Stability result{.margin = std::numeric_limits<double>::infinity()};
  if (energy_hessian.size() == 0) return result;
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(energy_hessian, Eigen::EigenvaluesOnly)
          .eigenvalues();
  const double zero = tolerance * std::max(1.0, values.cwiseAbs().maxCoeff());
  for (const double value : values) {
    if (std::abs(value) <= zero) {
      ++result.neutral;
      continue;
    }
    result.unstable += value < 0;
    result.margin = std::min(result.margin, value);
  }
  return result;
}

Stability combined(const Stability& a, const Stability& b) {
  return {a.unstable + b.unstable, a.neutral + b.neutral, std::min(a.margin, b.margin)};
}

}  // namespace kinetostat::vjm
