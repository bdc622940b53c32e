#include "kinetostat/calibration/statistics/robust_residual.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/spatial/products.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nearly_free = 1e-9;  // precision of what is free, over its information
constexpr double alone = 1e-9;        // left of a value that nothing else predicts

// Columns of one length, so that one small number is small beside each.
MatrixXd of_one_length(MatrixXd columns) {
  for (Index j = 0; j < columns.cols(); ++j)
    if (const double length = columns.col(j).norm(); length > 0)
      columns.col(j) *= std::sqrt(static_cast<double>(columns.rows())) / length;
  return columns;
}

}  // namespace

RobustResidual robust_residual(const VectorXd& y, const MatrixXd& free, const MatrixXd& usual,
                               double bend, int rounds) {
  MatrixXd x(y.size(), free.cols() + usual.cols());
  x << of_one_length(free), usual;
  VectorXd ridge(x.cols());
  ridge << VectorXd::Constant(free.cols(), nearly_free), VectorXd::Ones(usual.cols());
  VectorXd weights = VectorXd::Ones(y.size());
  RobustResidual result{y, y};
  for (int round = 1; round <= rounds; ++round) {
    const MatrixXd weighted = weights.asDiagonal() * x;
    MatrixXd a = spatial::transposed_product(x, weighted);
    a.diagonal() += ridge;
    MatrixXd right(x.cols(), round == rounds ? y.size() + 1 : 1);
    right.col(0) = weighted.transpose() * y;
    if (round == rounds) right.rightCols(y.size()) = x.transpose();
    const MatrixXd solved = spatial::solve_symmetric(a, right);
    result.left = y - x * solved.col(0);
    if (round == rounds)
      for (Index i = 0; i < y.size(); ++i) {
        const double spread = x.row(i).dot(solved.col(i + 1));  // h_i / w_i
        const double own = 1 - weights[i] * spread;             // 1 - h_i
        result.surprise[i] = own > alone ? result.left[i] / own / std::sqrt(1 + spread / own) : 0;
      }
    weights = (bend / result.left.array().abs().max(1e-300)).min(1.0);
  }
  return result;
}

}  // namespace kinetostat::calibration
