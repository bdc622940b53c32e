// The smoother of all multigrid levels.
#pragma once

#include <cstddef>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"

namespace kinetostat::fea {

/// Chebyshev polynomial of the fourth kind in D^-1 A with D the diagonal blocks, weighted to be the
/// best for a V-cycle (Lottes, Optimal polynomial smoothers for multigrid V-cycles, 2022; Phillips
/// and Fischer, the same year, table of beta).
class ChebyshevSmoother {
 public:
  static constexpr int degree = 3;

  /// Finds the largest eigenvalue of D^-1 A by a few iterations. Keeps a reference to the product.
  ChebyshevSmoother(MultiVectorProduct& product, common::Progress& progress);

  /// One pass: x += p(D^-1 A) D^-1 r, and r becomes the residual of the new x unless it is the
  /// last use of r. `d` and `w` are workspace.
  void smooth(MultiVector& x, MultiVector& r, MultiVector& d, MultiVector& w,
              bool needs_residual) const;

  /// Largest eigenvalue of D^-1 A.
  double largest_eigenvalue() const { return largest_eigenvalue_; }
  std::size_t bytes() const { return sizeof(double) * inverse_.size(); }

 private:
  // d = scale * D^-1 r on some blocks.
  void begin(std::ptrdiff_t first, std::ptrdiff_t blocks, double scale, const MultiVector& r,
             MultiVector& d) const;

  MultiVectorProduct& product_;
  std::vector<double> inverse_;  // of the diagonal blocks, nine each
  double largest_eigenvalue_ = 0;
};

}  // namespace kinetostat::fea
