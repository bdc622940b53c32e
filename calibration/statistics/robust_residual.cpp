#include "kinetostat/calibration/statistics/robust_residual.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The residual under given weights.
using Weighted = std::function<VectorXd(const VectorXd& weights)>;

// Columns of one length, so that one small number is small beside each.
MatrixXd of_one_length(MatrixXd columns) {
  for (Index j = 0; j < columns.cols(); ++j)
    if (const double length = columns.col(j).norm(); length > 0)
      columns.col(j) *= std::sqrt(static_cast<double>(columns.rows())) / length;
  return columns;
}

Weighted by_unknowns(const VectorXd& y, const MatrixXd& free, const MatrixXd& usual) {
  constexpr double nearly_free = 1e-9;
  MatrixXd x(y.size(), free.cols() + usual.cols());
  x << of_one_length(free), usual;
  VectorXd ridge(x.cols());
  ridge << VectorXd::Constant(free.cols(), nearly_free), VectorXd::Ones(usual.cols());
  return [y, x = std::move(x), ridge = std::move(ridge)](const VectorXd& weights) -> VectorXd {
    MatrixXd a = x.transpose() * weights.asDiagonal() * x;
    a.diagonal() += ridge;
    return y - x * spatial::solve_symmetric(a, x.transpose() * weights.cwiseProduct(y));
  };
}

// By the covariance E E' + W^-1 of the values: r = W^-1 S^-1 (y - B b), b by generalised least
// squares.
Weighted by_values(const VectorXd& y, const MatrixXd& free, const MatrixXd& usual) {
  MatrixXd covariance = usual * usual.transpose();
  return [y, b = of_one_length(free),
          covariance = std::move(covariance)](const VectorXd& weights) -> VectorXd {
    MatrixXd s = covariance;
    s.diagonal() += weights.cwiseInverse();
    MatrixXd right(y.size(), b.cols() + 1);
    right << b, y;
    const MatrixXd solved = spatial::solve_symmetric(s, right);
    const VectorXd free_values = spatial::shortest_least_squares_solution(
        b.transpose() * solved.leftCols(b.cols()), b.transpose() * solved.rightCols<1>(), 1e-12);
    return weights.cwiseInverse().cwiseProduct(solved.rightCols<1>() -
                                               solved.leftCols(b.cols()) * free_values);
  };
}

}  // namespace

VectorXd robust_residual(const VectorXd& y, const MatrixXd& free, const MatrixXd& usual,
                         double bend, int rounds) {
  const Weighted residual = free.cols() + usual.cols() > y.size() ? by_values(y, free, usual)
                                                                  : by_unknowns(y, free, usual);
  VectorXd weights = VectorXd::Ones(y.size()), left = y;
  for (int round = 0; round < rounds; ++round) {
    left = residual(weights);
    weights = (bend / left.array().abs().max(1e-300)).min(1.0);
  }
  return left;
}

}  // namespace kinetostat::calibration
