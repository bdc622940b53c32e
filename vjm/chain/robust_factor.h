// Small dense linear systems that may be singular.
#pragma once

#include <vector>

#include <Eigen/QR>

namespace kinetostat::vjm {

/// P A = L U with partial pivots, column by column. For matrices of a few dozen rows, where the
/// blocks of Eigen's PartialPivLU cost more than they save.
class SmallLu {
 public:
  /// `matrix` is square. Allocates nothing where the size is that of the last call.
  void compute(const Eigen::MatrixXd& matrix);
  /// Smallest over largest pivot.
  double pivot_ratio() const;
  /// Replaces right-hand sides by solutions. Requires pivots.
  template <class Columns>
  void solve_in_place(Eigen::MatrixBase<Columns>& columns) const {
    for (Eigen::Index j = 0; j < columns.cols(); ++j) {
      auto x = columns.col(j);
      const Eigen::Index n = lu_.rows();
      for (Eigen::Index k = 0; k < n; ++k)
        if (const Eigen::Index other = swapped_[static_cast<std::size_t>(k)]; other != k)
          std::swap(x[k], x[other]);
      for (Eigen::Index k = 0; k < n; ++k)
        if (x[k] != 0) x.tail(n - k - 1) -= x[k] * lu_.col(k).tail(n - k - 1);
      for (Eigen::Index k = n - 1; k >= 0; --k) {
        x[k] /= lu_(k, k);
        x.head(k) -= x[k] * lu_.col(k).head(k);
      }
    }
  }

  /// The same with the transposed matrix, for right-hand sides that stand row by row.
  template <class Rows>
  void solve_transposed_in_place(Eigen::MatrixBase<Rows>& x) const {
    const Eigen::Index n = lu_.rows();
    for (Eigen::Index k = 0; k < n; ++k) {
      for (Eigen::Index i = 0; i < k; ++i) x.row(k) -= lu_(i, k) * x.row(i);
      x.row(k) /= lu_(k, k);
    }
    for (Eigen::Index k = n - 1; k >= 0; --k)
      for (Eigen::Index i = k + 1; i < n; ++i) x.row(k) -= lu_(i, k) * x.row(i);
    for (Eigen::Index k = n - 1; k >= 0; --k)
      if (const Eigen::Index other = swapped_[static_cast<std::size_t>(k)]; other != k)
        x.row(k).swap(x.row(other));
  }

 private:
  Eigen::MatrixXd lu_;
  std::vector<Eigen::Index> swapped_;  // with which row each was
};

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
    solution = right.derived();
    if (right.rows() > 0) lu_.solve_in_place(solution);
  }
  /// Replaces right-hand sides by solutions with the transposed matrix. Requires a regular one.
  template <class Rows>
  void solve_transposed_in_place(Eigen::MatrixBase<Rows>& rows) const {
    lu_.solve_transposed_in_place(rows);
  }
  bool singular() const { return singular_; }

 private:
  Eigen::MatrixXd matrix_;
  SmallLu lu_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> orthogonal_;
  bool singular_ = false;
};

/// Whether the columns of a matrix span all of its rows' space; pivots below 1e-10 times the
/// largest count as zero.
bool has_full_row_rank(const Eigen::MatrixXd& matrix);

/// Whether the distance of every row from those before it is more than a thousandth of the longest
/// row: a Cholesky factorisation of their products, for up to six rows. False says nothing.
bool has_clearly_full_row_rank(const Eigen::MatrixXd& matrix);
/// The same from the products of the rows.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
bool is_clearly_positive(SmallMatrix products);

/// Columns spanning the null space of a matrix, orthonormal; pivots below `tolerance` times the
/// largest count as zero.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& matrix, double tolerance = 1e-10);

}  // namespace kinetostat::vjm
