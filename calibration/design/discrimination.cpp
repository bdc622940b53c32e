#include "kinetostat/calibration/design/discrimination.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Separation::Separation(const Forecast& a, const Forecast& b, const MatrixXd& common) {
  MatrixXd directions(a.mean.size(), a.spread.cols() + b.spread.cols() + common.cols());
  directions << a.spread / std::sqrt(2.0), b.spread / std::sqrt(2.0), common;
  const VectorXd difference = a.mean - b.mean;
  gram_ = directions.transpose() * directions;
  along_ = directions.transpose() * difference;
  difference_ = difference.squaredNorm();
}

Separation& Separation::operator+=(const Separation& other) {
  if (gram_.size() == 0) return *this = other;
  gram_ += other.gram_;
  along_ += other.along_;
  difference_ += other.difference_;
  return *this;
}

// (I + K K')^-1 = I - K (I + K'K)^-1 K'.
double Separation::squared() const {
  if (gram_.size() == 0) return std::max(0.0, difference_);
  MatrixXd a = gram_;
  a.diagonal().array() += 1;
  return std::max(0.0, difference_ - along_.dot(spatial::solve_symmetric(a, along_).col(0)));
}

MatrixXd Knowledge::gain(const Forecast& forecast, const MatrixXd& common) {
  const MatrixXd& j = forecast.spread;
  MatrixXd gain = j.transpose() * j;
  if (common.cols() == 0) return gain;
  MatrixXd a = common.transpose() * common;
  a.diagonal().array() += 1;
  const MatrixXd shared = common.transpose() * j;
  return gain - shared.transpose() * spatial::solve_symmetric(a, shared);
}

MatrixXd Knowledge::covariance() const {
  return spatial::solve_symmetric(gain_, MatrixXd::Identity(gain_.rows(), gain_.cols()));
}

double Knowledge::mean_square(const MatrixXd& spread) const {
  if (spread.rows() == 0 || spread.cols() == 0) return 0;
  return (spread * covariance()).cwiseProduct(spread).sum() / static_cast<double>(spread.rows());
}

MatrixXd root_of(const MatrixXd& covariance) {
  const Index n = covariance.rows();
  if (n == 0) return MatrixXd(0, 0);
  // Parameters of all units, so scaled to unit variance first.
  const VectorXd deviations = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  VectorXd inverse = deviations;
  for (double& d : inverse) d = d > 0 ? 1 / d : 0;
  const spatial::SymmetricEigen eigen =
      spatial::symmetric_eigen(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  const VectorXd roots = eigen.values.cwiseMax(0).cwiseSqrt();
  MatrixXd root = deviations.asDiagonal() * eigen.vectors * roots.asDiagonal();
  MatrixXd kept(n, 0);
  for (Index k = 0; k < n; ++k) {
    if (!(roots[k] > 0)) continue;
    kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
    kept.rightCols<1>() = root.col(k);
  }
  return kept;
}

}  // namespace kinetostat::calibration
