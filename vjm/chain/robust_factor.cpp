#include "kinetostat/vjm/chain/robust_factor.h"

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;

void SmallLu::compute(const MatrixXd& matrix) {
  lu_ = matrix;
  const Index n = lu_.rows();
  swapped_.resize(static_cast<std::size_t>(n));
  for (Index k = 0; k < n; ++k) {
    const Index below = n - k - 1;
    Index pivot = 0;
    const double largest = lu_.col(k).tail(n - k).cwiseAbs().maxCoeff(&pivot);
    swapped_[static_cast<std::size_t>(k)] = k + pivot;
    if (pivot != 0) lu_.row(k).swap(lu_.row(k + pivot));
    if (!(largest > 0)) continue;
    lu_.col(k).tail(below) /= lu_(k, k);
    for (Index j = k + 1; j < n; ++j)
      if (const double factor = lu_(k, j); factor != 0)
        lu_.col(j).tail(below) -= factor * lu_.col(k).tail(below);
  }
}

double SmallLu::pivot_ratio() const {
  const auto pivots = lu_.diagonal().cwiseAbs();
  return pivots.minCoeff() / pivots.maxCoeff();
}

void RobustFactor::compute(const MatrixXd& matrix) {
  singular_ = false;
  if (matrix.size() == 0) return;
  lu_.compute(matrix);
  singular_ = !(lu_.pivot_ratio() > 1e-13);
  if (!singular_) return;
  matrix_ = matrix;
  orthogonal_.setThreshold(1e-11);
  orthogonal_.compute(matrix);
}

MatrixXd RobustFactor::solve(const MatrixXd& right, bool* consistent) const {
  if (consistent) *consistent = true;
  if (right.rows() == 0) return right;
  if (!singular_) {
    MatrixXd solution = right;
    lu_.solve_in_place(solution);
    return solution;
  }
  MatrixXd solution = orthogonal_.solve(right);
  if (consistent) *consistent = (matrix_ * solution - right).norm() <= 1e-8 * right.norm();
  return solution;
}

bool has_clearly_full_row_rank(const MatrixXd& matrix) {
  return matrix.rows() <= SmallMatrix::MaxRowsAtCompileTime &&
         is_clearly_positive(matrix.lazyProduct(matrix.transpose()));
}

bool is_clearly_positive(SmallMatrix left) {
  constexpr double far = 1e-6;
  const double largest = left.diagonal().maxCoeff();
  for (Index k = 0; k < left.rows(); ++k) {
    if (!(left(k, k) > far * largest)) return false;
    for (Index j = k + 1; j < left.rows(); ++j)
      left.col(j).tail(left.rows() - j) -=
          left(j, k) / left(k, k) * left.col(k).tail(left.rows() - j);
  }
  return true;
}

bool has_full_row_rank(const MatrixXd& matrix) {
  if (matrix.cols() < matrix.rows()) return false;
  if (has_clearly_full_row_rank(matrix)) return true;
  return spatial::rank_of(matrix, 1e-10) == matrix.rows();
}

MatrixXd null_space(const MatrixXd& matrix, double tolerance) {
  if (matrix.size() == 0) return MatrixXd::Identity(matrix.cols(), matrix.cols());
  return spatial::complement_of(matrix.transpose(), tolerance);
}

}  // namespace kinetostat::vjm
