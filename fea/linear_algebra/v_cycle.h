// One step of multigrid between two levels.
#pragma once

#include <algorithm>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/linear_algebra/chebyshev_smoother.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"

namespace kinetostat::fea {

/// Smooth, correct by the level below, smooth: symmetric when the correction is.
class VCycle {
 public:
  /// Keeps a reference to the product.
  VCycle(MultiVectorProduct& product, common::Progress& progress)
      : product_(product),
        smoother_(product, progress),
        residual_(static_cast<std::size_t>(product.matrix().size())),
        direction_(residual_.size()),
        work_(residual_.size()) {}

  const ChebyshevSmoother& smoother() const { return smoother_; }
  std::size_t bytes() const { return smoother_.bytes() + 3 * sizeof(Lanes) * residual_.size(); }

  /// z = M r. correct(residual, correction) asks the level below.
  template <class Correct>
  void operator()(const MultiVector& r, MultiVector& z, const Correct& correct) {
    product_.for_each_piece([&](int first, int blocks) {
      std::copy_n(r.begin() + 3 * first, 3 * blocks, residual_.begin() + 3 * first);
      std::fill_n(z.begin() + 3 * first, 3 * blocks, Lanes{});
    });
    smoother_.smooth(z, residual_, direction_, work_, true);
    correct(residual_, direction_);
    product_(direction_, work_, [&](int piece) {
      const int first = product_.first(piece), count = 3 * (product_.end(piece) - first);
      add(1, direction_.data() + 3 * first, count, z.data() + 3 * first);
      add(-1, work_.data() + 3 * first, count, residual_.data() + 3 * first);
    });
    smoother_.smooth(z, residual_, direction_, work_, false);
  }

 private:
  MultiVectorProduct& product_;
  ChebyshevSmoother smoother_;
  MultiVector residual_, direction_, work_;
};

}  // namespace kinetostat::fea
