// One step of multigrid between two levels.
#pragma once

#include <algorithm>
#include <cstddef>

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
      const std::ptrdiff_t from = lanes(first), count = lanes(blocks);
      std::copy_n(r.begin() + from, count, residual_.begin() + from);
      std::fill_n(z.begin() + from, count, Lanes{});
    });
    smoother_.smooth(z, residual_, direction_, work_, true);
    correct(residual_, direction_);
    product_(direction_, work_, [&](int piece) {
      const std::ptrdiff_t from = lanes(product_.first(piece));
      const std::ptrdiff_t count = lanes(product_.end(piece)) - from;
      add(1, direction_.data() + from, count, z.data() + from);
      add(-1, work_.data() + from, count, residual_.data() + from);
    });
    smoother_.smooth(z, residual_, direction_, work_, false);
  }

 private:
  // Of so many blocks of three.
  static std::ptrdiff_t lanes(int blocks) { return 3 * std::ptrdiff_t{blocks}; }

  MultiVectorProduct& product_;
  ChebyshevSmoother smoother_;
  MultiVector residual_, direction_, work_;
};

}  // namespace kinetostat::fea
