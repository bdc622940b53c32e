// Small dense linear systems that may be singular.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>

namespace kinetostat::vjm {

/// LU where it is safe, a rank-revealing orthogonal decomposition (least squares, shortest
/// solution) where pivots vanish: redundant passive joints and indeterminate reactions.
class RobustFactor {
 public:
  void compute(const Eigen::MatrixXd& matrix);
  /// `consistent` becomes false when no solution exists.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right, bool* consistent = nullptr) const;
  /// The same into a vector or matrix that is kept: where the matrix is regular and the sizes are
  /// those of the last call, no memory is allocated.
  template <class Right, class Solution>
  void solve(const Eigen::MatrixBase<Right>& right, Solution& solution, bool* consistent) const {
    if (singular_) {
      solution = solve(Eigen::MatrixXd(right), consistent);
      return;
    }
    if (consistent) *consistent = true;
    if (right.rows() > 0) solution = lu_.solve(right.derived());
  }
  bool singular() const { return singular_; }

 private:
  Eigen::MatrixXd matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> orthogonal_;
  bool singular_ = false;
};

/// Whether the columns of a matrix span all of its rows' space; pivots below 1e-10 times the
/// largest count as zero.
bool has_full_row_rank(const Eigen::MatrixXd& matrix);

/// Columns spanning the null space of a matrix, orthonormal; pivots below `tolerance` times the
/// largest count as zero.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& matrix, double tolerance = 1e-10);

}  // namespace kinetostat::vjm
