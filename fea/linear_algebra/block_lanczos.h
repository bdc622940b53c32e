// The largest eigenvalues of a symmetric problem whose matrix is known by its products alone.
#pragma once

#include <functional>

#include <Eigen/Core>

#include "kinetostat/common/progress.h"

namespace kinetostat::fea {

/// Y = A X, one column each.
using Product = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

/// Values descending; vectors M-orthonormal, x' M x = 1.
struct EigenPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

struct LanczosOptions {
  /// Of a pair (theta, x): |A M x - theta x|_M beside theta. The error of theta is about its
  /// square.
  double tolerance = 1e-8;
  /// Columns that are kept; beyond, the method goes on from the best of them. 0: as many as serve.
  Eigen::Index most_columns = 0;
  int most_blocks = 400;  // products with A
};

/// The `count` largest theta with A M x = theta x; A and M symmetric and positive semi-definite, of
/// this size. By Lanczos' method with full orthogonalisation in blocks of eight columns, so that up
/// to eight equal eigenvalues are all found, and with thick restarts (Wu and Simon 2000, SIAM J.
/// Matrix Anal. Appl. 22:602). Fewer pairs where A M has no more that are not zero. With A = K^-1
/// they are the lowest of K x = x M x / theta. Throws common::NoConvergence, Cancelled.
EigenPairs largest_eigenpairs(const Product& a, const Product& mass, Eigen::Index size, int count,
                              const LanczosOptions& options, common::Progress& progress);

}  // namespace kinetostat::fea
