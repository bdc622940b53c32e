// A coarse level where there is no mesh for one: groups of neighbours that move as rigid bodies,
// smoothed (Vanek, Mandel and Brezina, Algebraic multigrid by smoothed aggregation, 1996).
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "kinetostat/common/thread_pool.h"
#include "kinetostat/fea/linear_algebra/block_matrix.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"
#include "kinetostat/fea/linear_algebra/rigid_aggregates.h"

namespace kinetostat::fea {

/// Rows of blocks with three unknowns times six: the motion of a rigid body for each column.
struct RigidRows {
  static constexpr int entries = 18;  // of a block, row by row
  std::vector<int> start = {0};
  std::vector<int> column = {};
  std::vector<double> value = {};

  int rows() const { return static_cast<int>(start.size()) - 1; }
  int column_of(int place) const { return column[static_cast<std::size_t>(place)]; }
  double* block(int place) { return value.data() + entries * static_cast<std::size_t>(place); }
  const double* block(int place) const {
    return value.data() + entries * static_cast<std::size_t>(place);
  }
  std::size_t bytes() const {
    return sizeof(int) * (start.size() + column.size()) + sizeof(double) * value.size();
  }
};

/// The same by columns: the rows that each is in, ascending, and the places of its blocks.
struct RigidColumns {
  std::vector<int> start, row, place;

  RigidColumns() = default;
  RigidColumns(const RigidRows& rows, int columns);
  std::size_t begin(int column) const {
    return static_cast<std::size_t>(start[static_cast<std::size_t>(column)]);
  }
  std::size_t end(int column) const { return begin(column + 1); }
};

/// A level made of aggregates: how the blocks above move with it, and its matrix P'AP.
class AggregateLevel {
 public:
  /// `largest_eigenvalue` of D^-1 A, D the diagonal blocks. P = (I - 4 / (3 largest) D^-1 A) T with
  /// T the rigid motions of the aggregates; rows of bodies are those of T.
  AggregateLevel(const BlockMatrix& matrix, const RigidPoints& points, double largest_eigenvalue,
                 common::ThreadPool& pool);

  const RigidPoints& points() const { return points_; }
  /// P'AP, until it is taken.
  const BlockMatrix& matrix() const { return matrix_; }
  BlockMatrix take_matrix() { return std::move(matrix_); }
  std::size_t bytes() const;

  /// fine = P coarse.
  void prolong(const MultiVector& coarse, MultiVector& fine) const;
  /// coarse = P' fine.
  void restrict(const MultiVector& fine, MultiVector& coarse) const;

 private:
  common::ThreadPool& pool_;
  RigidPoints points_;
  RigidRows prolongation_;
  RigidColumns columns_;  // of the prolongation
  BlockMatrix matrix_;
};

}  // namespace kinetostat::fea
