#include "kinetostat/spatial/products.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "kinetostat/common/several_processors.h"

namespace kinetostat::spatial {
namespace products_in_tiles {
namespace {

using Eigen::Index;

// A tile of the product is as many rows as two of the widest registers hold, and as many columns as
// leave some registers of all processors free.
constexpr Index bytes = 64, tile_columns = 3;
template <class Scalar>
constexpr Index tile_rows = 2 * bytes / static_cast<Index>(sizeof(Scalar));
// Terms of the sums that are taken before the next tile: their rows stay in a cache.
constexpr Index most_depth = 512;

// Columns of the second factor, and of the product from the first row of the tile on.
template <class Scalar>
struct Columns {
  std::array<const Scalar*, tile_columns> factor;
  std::array<Scalar*, tile_columns> sums;
};

// sums += panel factor. The panel has the rows of the tile side by side, term by term.
template <class Scalar>
[[gnu::always_inline]] inline void add_to_tile(const Scalar* panel, Index depth,
                                               const Columns<Scalar>& columns) {
  typedef Scalar Lanes __attribute__((vector_size(bytes), aligned(alignof(Scalar)), may_alias));
  const auto* a = reinterpret_cast<const Lanes*>(panel);
  const auto [b0, b1, b2] = columns.factor;
  auto* sum0 = reinterpret_cast<Lanes*>(columns.sums[0]);
  auto* sum1 = reinterpret_cast<Lanes*>(columns.sums[1]);
  auto* sum2 = reinterpret_cast<Lanes*>(columns.sums[2]);
  Lanes upper0 = sum0[0], lower0 = sum0[1], upper1 = sum1[0], lower1 = sum1[1], upper2 = sum2[0],
        lower2 = sum2[1];
  for (Index k = 0; k < depth; ++k) {
    const Lanes upper = a[2 * k], lower = a[2 * k + 1];
    upper0 += upper * b0[k];
    lower0 += lower * b0[k];
    upper1 += upper * b1[k];
    lower1 += lower * b1[k];
    upper2 += upper * b2[k];
    lower2 += lower * b2[k];
  }
  sum0[0] = upper0;
  sum0[1] = lower0;
  sum1[0] = upper1;
  sum1[1] = lower1;
  sum2[0] = upper2;
  sum2[1] = lower2;
}

KINETOSTAT_FOR_SEVERAL_PROCESSORS
void add(const double* panel, Index depth, const Columns<double>& columns) {
  add_to_tile(panel, depth, columns);
}
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void add(const float* panel, Index depth, const Columns<float>& columns) {
  add_to_tile(panel, depth, columns);
}

// Adds the terms from `first` on to the part of `sum` that the panel has the rows of.
template <class Scalar, class Matrix, class Part>
void add_terms(const Scalar* panel, Index first, Index depth, const Matrix& b, Part sum) {
  Eigen::Matrix<Scalar, tile_rows<Scalar>, tile_columns> tile;
  for (Index left = 0; left < sum.cols(); left += tile_columns) {
    const Index width = std::min(tile_columns, sum.cols() - left);
    const bool is_whole = sum.rows() == tile.rows() && width == tile_columns;
    auto part = sum.middleCols(left, width);
    if (!is_whole) {
      tile.setZero();
      tile.topLeftCorner(sum.rows(), width) = part;
    }
    Columns<Scalar> columns{};
    for (Index j = 0; j < tile_columns; ++j) {
      const auto at = static_cast<std::size_t>(j);
      columns.factor[at] = b.data() + (left + std::min(j, width - 1)) * b.outerStride() + first;
      columns.sums[at] = is_whole ? &part(0, j) : &tile(0, j);
    }
    add(panel, depth, columns);
    if (!is_whole) part = tile.topLeftCorner(sum.rows(), width);
  }
}

// Rows of a matrix by columns, or of its transpose, side by side; zeros fill the tile.
template <class Matrix, bool is_transposed>
struct PackedRows {
  using Scalar = typename Matrix::Scalar;
  const Matrix& a;

  void pack(Index top, Index count, Index first, Index depth, Scalar* panel) const {
    Eigen::Map<Eigen::Matrix<Scalar, tile_rows<Scalar>, Eigen::Dynamic>> packed(
        panel, tile_rows<Scalar>, depth);
    if (count < tile_rows<Scalar>) packed.setZero();
    if constexpr (is_transposed) {
      packed.topRows(count) = a.block(first, top, depth, count).transpose();
    } else {
      packed.topRows(count) = a.block(top, first, count, depth);
    }
  }
};

template <bool is_transposed, class Matrix, class Sum>
void add_product_to(const Matrix& a, const Matrix& b, Sum& sum) {
  using Scalar = typename Matrix::Scalar;
  const Index terms = is_transposed ? a.rows() : a.cols();
  assert(terms == b.rows() && b.cols() == sum.cols());
  constexpr Index height = tile_rows<Scalar>;
  thread_local std::array<Scalar, static_cast<std::size_t>(height * most_depth)> panel;
  const PackedRows<Matrix, is_transposed> rows{a};
  for (Index first = 0; first < terms; first += most_depth)
    for (Index top = 0; top < sum.rows(); top += height) {
      const Index depth = std::min(most_depth, terms - first),
                  count = std::min(height, sum.rows() - top);
      rows.pack(top, count, first, depth, panel.data());
      add_terms(panel.data(), first, depth, b, sum.middleRows(top, count));
    }
}

}  // namespace
}  // namespace products_in_tiles

using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::Ref;

void add_product(const Ref<const MatrixXd>& a, const Ref<const MatrixXd>& b, Ref<MatrixXd> c) {
  products_in_tiles::add_product_to<false>(a, b, c);
}
MatrixXd transposed_product(const Ref<const MatrixXd>& a, const Ref<const MatrixXd>& b) {
  MatrixXd sum = MatrixXd::Zero(a.cols(), b.cols());
  products_in_tiles::add_product_to<true>(a, b, sum);
  return sum;
}
MatrixXf transposed_product(const Ref<const MatrixXf>& a, const Ref<const MatrixXf>& b) {
  MatrixXf sum = MatrixXf::Zero(a.cols(), b.cols());
  products_in_tiles::add_product_to<true>(a, b, sum);
  return sum;
}

}  // namespace kinetostat::spatial
