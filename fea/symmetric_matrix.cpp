#include "kinetostat/fea/symmetric_matrix.h"

namespace kinetostat::fea {

Eigen::MatrixXd SymmetricMatrix::residual(const Eigen::MatrixXd& b,
                                          const Eigen::MatrixXd& x) const {
  // Rows on end, so that all right-hand sides share one pass over the matrix.
  using Rows = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Rows in = x.cast<long double>();
  Rows out = b.cast<long double>();
  for (Eigen::Index j = 0; j < size(); ++j) {
    const int first = column_start[static_cast<std::size_t>(j)];
    const int last = column_start[static_cast<std::size_t>(j) + 1];
    for (int k = first; k < last; ++k) {
      const int i = row[static_cast<std::size_t>(k)];
      const long double a = value[static_cast<std::size_t>(k)];
      out.row(i) -= a * in.row(j);
      if (i != j) out.row(j) -= a * in.row(i);
    }
  }
  return out.cast<double>();
}

}  // namespace kinetostat::fea
