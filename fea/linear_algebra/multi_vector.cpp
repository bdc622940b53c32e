#include "kinetostat/fea/linear_algebra/multi_vector.h"

#include <algorithm>
#include <utility>

#include "kinetostat/common/index.h"
#include "kinetostat/common/several_processors.h"

namespace kinetostat::fea {
namespace {

using common::at;

using Register = double __attribute__((vector_size(sizeof(Lanes)), may_alias));

constexpr int most_rows = 4096, least_rows = 256;
constexpr int wanted_pieces = 16;

// Rows of a piece: enough pieces to share them out evenly, each small enough for a cache.
int rows_per_piece(int blocks) { return std::clamp(blocks / wanted_pieces, least_rows, most_rows); }

// The first of the three unknowns of a block.
constexpr std::ptrdiff_t first_of(int block) { return 3 * std::ptrdiff_t{block}; }

// One block row: y_row = sum of A_k x_k, and y_k += A_k' x_row for the blocks right of the
// diagonal. Those up to `inside` have their y in `y`, the others in `sum` at their slots.
KINETOSTAT_FOR_SEVERAL_PROCESSORS
void multiply_rows(const BlockPattern& pattern, const double* values, int first, int end,
                   const int* slot, const Lanes* x_lanes, Lanes* y_lanes, Lanes* sum_lanes) {
  const auto* x = reinterpret_cast<const Register*>(x_lanes);
  auto* y = reinterpret_cast<Register*>(y_lanes);
  auto* sum = reinterpret_cast<Register*>(sum_lanes);
  for (int row = first; row < end; ++row) {
    const std::size_t begin = pattern.begin(row), last = pattern.end(row);
    const Register* own = x + first_of(row);
    Register* result = y + first_of(row);
    const Register x0 = own[0], x1 = own[1], x2 = own[2];
    const double* a = values + 9 * begin;
    Register y0 = result[0] + a[0] * x0 + a[1] * x1 + a[2] * x2;
    Register y1 = result[1] + a[3] * x0 + a[4] * x1 + a[5] * x2;
    Register y2 = result[2] + a[6] * x0 + a[7] * x1 + a[8] * x2;
    for (std::size_t k = begin + 1; k < last; ++k) {
      const int column = pattern.partner[k];
      const Register* in = x + first_of(column);
      Register* out = column < end ? y + first_of(column) : sum + first_of(*slot++);
      a += 9;
      const Register i0 = in[0], i1 = in[1], i2 = in[2];
      y0 += a[0] * i0 + a[1] * i1 + a[2] * i2;
      y1 += a[3] * i0 + a[4] * i1 + a[5] * i2;
      y2 += a[6] * i0 + a[7] * i1 + a[8] * i2;
      out[0] += a[0] * x0 + a[3] * x1 + a[6] * x2;
      out[1] += a[1] * x0 + a[4] * x1 + a[7] * x2;
      out[2] += a[2] * x0 + a[5] * x1 + a[8] * x2;
    }
    result[0] = y0;
    result[1] = y1;
    result[2] = y2;
  }
}

}  // namespace

MultiVector to_multi_vector(const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  MultiVector lanes(at(columns.rows()), Lanes{});
  for (Eigen::Index j = 0; j < columns.cols(); ++j)
    for (Eigen::Index i = 0; i < columns.rows(); ++i) lanes[at(i)].v[j] = columns(i, j);
  return lanes;
}

void from_multi_vector(const MultiVector& lanes, Eigen::Ref<Eigen::MatrixXd> columns) {
  for (Eigen::Index j = 0; j < columns.cols(); ++j)
    for (Eigen::Index i = 0; i < columns.rows(); ++i) columns(i, j) = lanes[at(i)].v[j];
}

KINETOSTAT_FOR_SEVERAL_PROCESSORS
void add(double weight, const Lanes* b_lanes, std::ptrdiff_t count, Lanes* a_lanes) {
  const auto* b = reinterpret_cast<const Register*>(b_lanes);
  auto* a = reinterpret_cast<Register*>(a_lanes);
  for (std::ptrdiff_t i = 0; i < count; ++i) a[i] += weight * b[i];
}

MultiVectorProduct::MultiVectorProduct(const BlockMatrix& matrix, common::ThreadPool& pool)
    : matrix_(matrix), pool_(pool) {
  const BlockPattern& pattern = matrix.pattern;
  const int rows = rows_per_piece(pattern.blocks());
  for (int row = 0; row < pattern.blocks(); row += rows) first_row_.push_back(row);
  first_row_.push_back(pattern.blocks());
  overhangs_.resize(at(pieces()));
  parts_.resize(at(pieces()));
  pool_.for_each(pieces(), [&](int piece) {
    Overhang& over = overhangs_[at(piece)];
    for (std::size_t k = pattern.begin(first(piece)); k < pattern.begin(end(piece)); ++k)
      if (pattern.partner[k] >= end(piece)) over.slot.push_back(pattern.partner[k]);
    over.row = over.slot;
    std::sort(over.row.begin(), over.row.end());
    over.row.erase(std::unique(over.row.begin(), over.row.end()), over.row.end());
    for (int& slot : over.slot)
      slot = static_cast<int>(std::lower_bound(over.row.begin(), over.row.end(), slot) -
                              over.row.begin());
    over.sum.resize(3 * over.row.size());
  });
  for (int piece = 0; piece < pieces(); ++piece) {
    const std::vector<int>& row = overhangs_[at(piece)].row;
    for (std::size_t i = 0; i < row.size();) {
      const int owner = row[i] / rows;
      const std::size_t begin = i;
      while (i < row.size() && row[i] / rows == owner) ++i;
      parts_[at(owner)].push_back({piece, static_cast<int>(begin), static_cast<int>(i)});
    }
  }
}

void MultiVectorProduct::multiply(int piece, const Lanes* x, Lanes* y) {
  Overhang& over = overhangs_[at(piece)];
  std::fill(over.sum.begin(), over.sum.end(), Lanes{});
  std::fill(y + first_of(first(piece)), y + first_of(end(piece)), Lanes{});
  multiply_rows(matrix_.pattern, matrix_.value.data(), first(piece), end(piece), over.slot.data(),
                x, y, over.sum.data());
}

void MultiVectorProduct::collect(int piece, Lanes* y) const {
  for (const Part& part : parts_[at(piece)]) {
    const Overhang& over = overhangs_[at(part.piece)];
    for (int i = part.first; i < part.last; ++i)
      for (int a = 0; a < 3; ++a)
        for (int lane = 0; lane < lane_count; ++lane)
          y[3 * over.row[at(i)] + a].v[lane] += over.sum[at(3 * i + a)].v[lane];
  }
}

std::size_t MultiVectorProduct::bytes() const {
  std::size_t bytes = 0;
  for (const Overhang& over : overhangs_)
    bytes += over.row.size() * sizeof(int) + over.slot.size() * sizeof(int) +
             over.sum.size() * sizeof(Lanes);
  return bytes;
}

}  // namespace kinetostat::fea
