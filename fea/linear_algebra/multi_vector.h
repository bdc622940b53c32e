// Eight right-hand sides side by side in memory, so that one pass over a matrix serves all and the
// processor works on them at once.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/common/thread_pool.h"
#include "kinetostat/fea/linear_algebra/block_matrix.h"

namespace kinetostat::fea {

inline constexpr int lane_count = 8;

/// One number for each right-hand side.
struct alignas(64) Lanes {
  double v[lane_count];
};

/// Blocks of three unknowns, each with its lanes: unknown 3b + i is element 3b + i.
using MultiVector = std::vector<Lanes>;

/// At most eight columns; the lanes without a column are zero.
MultiVector to_multi_vector(const Eigen::Ref<const Eigen::MatrixXd>& columns);
void from_multi_vector(const MultiVector& lanes, Eigen::Ref<Eigen::MatrixXd> columns);

/// a += weight * b.
void add(double weight, const Lanes* b, std::ptrdiff_t count, Lanes* a);

/// Products with a symmetric matrix on several threads. Rows are worked on in pieces that depend
/// on the matrix alone; what a piece adds to rows of later pieces is kept apart and added in the
/// order of the pieces, so the number of threads changes no digit.
class MultiVectorProduct {
 public:
  /// Keeps references to both.
  MultiVectorProduct(const BlockMatrix& matrix, common::ThreadPool& pool);

  const BlockMatrix& matrix() const { return matrix_; }
  common::ThreadPool& pool() const { return pool_; }
  int pieces() const { return static_cast<int>(first_row_.size()) - 1; }
  /// Blocks first to end - 1 of a piece.
  int first(int piece) const { return first_row_[static_cast<std::size_t>(piece)]; }
  int end(int piece) const { return first(piece + 1); }

  /// y = A x, then then(piece) for every piece, when its rows of y are complete.
  template <class Then>
  void operator()(const MultiVector& x, MultiVector& y, const Then& then) {
    pool_.for_each(pieces(), [&](int piece) { multiply(piece, x.data(), y.data()); });
    pool_.for_each(pieces(), [&](int piece) {
      collect(piece, y.data());
      then(piece);
    });
  }

  /// work(first block, number of blocks) for every piece.
  template <class Work>
  void for_each_piece(const Work& work) const {
    pool_.for_each(pieces(), [&](int piece) { work(first(piece), end(piece) - first(piece)); });
  }

  /// Bytes that the object holds beside the matrix.
  std::size_t bytes() const;

 private:
  struct Overhang {
    std::vector<int> row;   // rows of later pieces, ascending
    std::vector<int> slot;  // for each block of the piece that lies in such a row: where in `row`
    MultiVector sum;        // three for each of row
  };
  struct Part {
    int piece;        // whose overhang
    int first, last;  // of its rows
  };

  void multiply(int piece, const Lanes* x, Lanes* y);
  void collect(int piece, Lanes* y) const;

  const BlockMatrix& matrix_;
  common::ThreadPool& pool_;
  std::vector<int> first_row_;
  std::vector<Overhang> overhangs_;
  std::vector<std::vector<Part>> parts_;  // of each piece: what earlier ones add to it
};

}  // namespace kinetostat::fea
