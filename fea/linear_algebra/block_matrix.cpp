#include "kinetostat/fea/linear_algebra/block_matrix.h"

#include <limits>
#include <stdexcept>

#include "kinetostat/common/index.h"

namespace kinetostat::fea {

using common::at;

void append(BlockPattern& pattern, const BlockPattern& rows) {
  const std::size_t before = pattern.partner.size();
  if (before + rows.partner.size() > at(std::numeric_limits<int>::max()))
    throw std::length_error("the stiffness matrix has more than 2^31 blocks");
  pattern.partner.insert(pattern.partner.end(), rows.partner.begin(), rows.partner.end());
  for (std::size_t b = 1; b < rows.start.size(); ++b)
    pattern.start.push_back(rows.start[b] + static_cast<int>(before));
}

Eigen::MatrixXd BlockMatrix::residual(const Eigen::MatrixXd& b, const Eigen::MatrixXd& x) const {
  // Rows on end, so that all right-hand sides share one pass over the matrix.
  using Rows = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Rows in = x.cast<long double>();
  Rows out = b.cast<long double>();
  for (int row = 0; row < pattern.blocks(); ++row)
    for (std::size_t k = pattern.begin(row); k < pattern.end(row); ++k) {
      const int column = pattern.partner[k];
      const Block a = block(k);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const long double entry = a(i, j);
          out.row(3 * row + i) -= entry * in.row(3 * column + j);
          if (row != column) out.row(3 * column + j) -= entry * in.row(3 * row + i);
        }
    }
  return out.cast<double>();
}

WholeRows::WholeRows(const BlockPattern& pattern) : start(at(pattern.blocks()) + 1, 0) {
  const auto for_each = [&pattern](const auto& visit) {
    for (int row = 0; row < pattern.blocks(); ++row)
      for (std::size_t k = pattern.begin(row); k < pattern.end(row); ++k)
        visit(row, pattern.partner[k], static_cast<int>(k));
  };
  for_each([this](int row, int other, int) {
    ++start[at(row) + 1];
    if (other != row) ++start[at(other) + 1];
  });
  for (std::size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
  column.resize(at(start.back()));
  place.resize(column.size());
  std::vector<int> next(start.begin(), start.end() - 1);
  const auto put = [&](int row, int other, int k) {
    const auto free = at(next[at(row)]++);
    column[free] = other;
    place[free] = k;
  };
  for_each([&put](int row, int other, int k) {
    put(row, other, k);
    if (other != row) put(other, row, ~k);
  });
}

}  // namespace kinetostat::fea
