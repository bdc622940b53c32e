// A large sparse symmetric matrix of 3x3 blocks.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::fea {

/// Which blocks of three unknowns are linked: for each, the numbers of itself and of its later
/// partners, ascending.
struct BlockPattern {
  std::vector<int> start = {0};
  std::vector<int> partner = {};

  int blocks() const { return static_cast<int>(start.size()) - 1; }
  /// Places in `partner` of the row of a block.
  std::size_t begin(int block) const {
    return static_cast<std::size_t>(start[static_cast<std::size_t>(block)]);
  }
  std::size_t end(int block) const { return begin(block + 1); }
};

/// Adds rows behind those of a pattern. Throws std::length_error beyond 2^31 blocks.
void append(BlockPattern& pattern, const BlockPattern& rows);

/// The diagonal and the blocks right of it; those below are their transposes.
struct BlockMatrix {
  BlockPattern pattern = {};
  std::vector<double> value = {};  // nine for each place in pattern.partner, row by row

  using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  Block block(std::size_t place) const { return Block(value.data() + 9 * place); }
  Eigen::Index size() const { return 3 * static_cast<Eigen::Index>(pattern.blocks()); }

  /// Memory of the matrix.
  std::size_t bytes() const {
    return sizeof(double) * value.size() +
           sizeof(int) * (pattern.partner.size() + pattern.start.size());
  }

  /// B - A X for several columns at once, summed in extended precision: where A X nearly cancels B,
  /// the digits that are left are right.
  Eigen::MatrixXd residual(const Eigen::MatrixXd& b, const Eigen::MatrixXd& x) const;
};

/// Both halves of a symmetric matrix, row by row.
struct WholeRows {
  std::vector<int> start;
  std::vector<int> column;  // of each block
  std::vector<int> place;   // of the stored block; ~place where that is the transpose

  explicit WholeRows(const BlockPattern& pattern);
  int begin(int row) const { return start[static_cast<std::size_t>(row)]; }
  int end(int row) const { return begin(row + 1); }
  static std::size_t stored(int place) {
    return static_cast<std::size_t>(place < 0 ? ~place : place);
  }
};

}  // namespace kinetostat::fea
