#include "kinetostat/calibration/statistics/residual_space.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/statistics/goodness_of_fit.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd beside(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

MatrixXd span_of(const MatrixXd& columns, double smallest) {
  MatrixXd scaled = columns;
  double longest = 0;
  for (Index j = 0; j < columns.cols(); ++j) longest = std::max(longest, columns.col(j).norm());
  if (longest <= smallest) return MatrixXd(columns.rows(), 0);
  Index kept = 0;
  for (Index j = 0; j < columns.cols(); ++j)
    if (const double length = columns.col(j).norm(); length > std::max(smallest, 1e-12 * longest))
      scaled.col(kept++) = columns.col(j) / length;
  return spatial::range_of(scaled.leftCols(kept), 1e-9);
}

ResidualSpace::ResidualSpace(const VectorXd& residual, const MatrixXd& fitted)
    : basis_(span_of(fitted)) {
  residual_ = left_of(residual);
}

MatrixXd ResidualSpace::left_of(const MatrixXd& columns) const {
  MatrixXd left = columns - basis_ * (basis_.transpose() * columns);
  return left - basis_ * (basis_.transpose() * left);  // once more, against rounding
}

Screen::Screen(const ResidualSpace& space, const std::vector<Signature>& signatures)
    : dimension_(space.dimension()) {
  for (const Signature& signature : signatures) {
    const MatrixXd left = space.left_of(signature.columns);
    detectability_.push_back(left.cols() == 0 ? 0 : left.col(0).norm());
    // Rounding of the part that the fit produces is no signature either.
    spans_.push_back(span_of(left, std::max(least_visible, 1e-7 * signature.columns.norm())));
  }
}

Score Screen::score(std::size_t i, const VectorXd& residual) const {
  return {.detectability = detectability_[i],
          .dimension = spans_[i].cols(),
          .explained = (spans_[i].transpose() * residual).squaredNorm()};
}

double Screen::significance(const Score& score, const VectorXd& residual) const {
  const auto k = static_cast<double>(score.dimension);
  const auto rest = static_cast<double>(dimension_ - score.dimension);
  if (score.dimension == 0 || rest < 1) return 0;
  const double noise = std::max(1.0, (residual.squaredNorm() - score.explained) / rest);
  const double f = score.explained / k / noise;
  if (!(f > 0)) return 0;
  return -std::log(std::max(chance_of_larger_f(f, k, rest), 1e-300));
}

double Screen::confusion(std::size_t i, std::size_t j) const {
  if (spans_[i].cols() == 0 || spans_[j].cols() == 0) return 0;
  const MatrixXd cosines = spans_[i].transpose() * spans_[j];
  return std::min(1.0, spatial::singular_value_decomposition(cosines).values[0]);
}

}  // namespace kinetostat::calibration
