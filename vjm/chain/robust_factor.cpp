#include "kinetostat/vjm/chain/robust_factor.h"

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {

using Eigen::MatrixXd;

void RobustFactor::compute(const MatrixXd& matrix) {
  singular_ = false;
  if (matrix.size() == 0) return;
  lu_.compute(matrix);
  const auto pivots = lu_.matrixLU().diagonal().cwiseAbs();
  singular_ = !(pivots.minCoeff() > 1e-13 * pivots.maxCoeff());
  if (!singular_) return;
  matrix_ = matrix;
  orthogonal_.setThreshold(1e-11);
  orthogonal_.compute(matrix);
}

MatrixXd RobustFactor::solve(const MatrixXd& right, bool* consistent) const {
  if (consistent) *consistent = true;
  if (right.rows() == 0) return right;
  if (!singular_) return lu_.solve(right);
  MatrixXd solution = orthogonal_.solve(right);
  if (consistent) *consistent = (matrix_ * solution - right).norm() <= 1e-8 * right.norm();
  return solution;
}

bool has_full_row_rank(const MatrixXd& matrix) {
  if (matrix.cols() < matrix.rows()) return false;
  return spatial::rank_of(matrix, 1e-10) == matrix.rows();
}

MatrixXd null_space(const MatrixXd& matrix, double tolerance) {
  if (matrix.size() == 0) return MatrixXd::Identity(matrix.cols(), matrix.cols());
  return spatial::complement_of(matrix.transpose(), tolerance);
}

}  // namespace kinetostat::vjm
