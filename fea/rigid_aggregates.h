// A coarse level where there is no mesh for one: groups of neighbours that move as rigid bodies,
// smoothed (Vanek, Mandel and Brezina, Algebraic multigrid by smoothed aggregation, 1996).
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/assembly.h"
#include "kinetostat/fea/block_matrix.h"
#include "kinetostat/fea/lanes.h"
#include "kinetostat/fea/team.h"

namespace kinetostat::fea {

/// What the blocks of unknowns of a level are: of each point a displacement, or a displacement and
/// a rotation; of each reference body, behind them all, both.
struct RigidPoints {
  std::vector<Vector3> points;  // [m], those of the bodies last
  int bodies = 0;
  bool turning = false;  // the points other than bodies have a rotation, too
  double length = 1;     // [m] of all: what a rotation [rad] is multiplied by to be the unknown

  int size() const { return static_cast<int>(points.size()); }
  int nodes() const { return size() - bodies; }
  int blocks() const { return (turning ? 2 : 1) * nodes() + 2 * bodies; }
  /// The displacement of a point; its rotation, if any, is the next block.
  int first_block(int point) const {
    return turning ? 2 * point : point + std::max(point - nodes(), 0);
  }
  int blocks_of(int point) const { return turning || point >= nodes() ? 2 : 1; }
};

/// Those of a model of first order.
RigidPoints rigid_points(const TetMesh& mesh, const Unknowns& unknowns);

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

/// Points that are strongly linked in one group each: its number, in the order of the points, or
/// -1 for points that have no neighbours to speak of. Bodies are groups of their own, the last
/// ones.
std::vector<int> rigid_aggregates(const BlockMatrix& matrix, const RigidPoints& points);

/// A level made of aggregates: how the blocks above move with it, and its matrix P'AP.
class AggregateLevel {
 public:
  /// `largest_eigenvalue` of D^-1 A, D the diagonal blocks. P = (I - 4 / (3 largest) D^-1 A) T with
  /// T the rigid motions of the aggregates; rows of bodies are those of T.
  AggregateLevel(const BlockMatrix& matrix, const RigidPoints& points, double largest_eigenvalue,
                 Team& team);

  const RigidPoints& points() const { return points_; }
  /// P'AP, until it is taken.
  const BlockMatrix& matrix() const { return matrix_; }
  BlockMatrix take_matrix() { return std::move(matrix_); }
  std::size_t bytes() const;

  /// fine = P coarse.
  void prolong(const LaneVector& coarse, LaneVector& fine) const;
  /// coarse = P' fine.
  void restrict(const LaneVector& fine, LaneVector& coarse) const;

 private:
  Team& team_;
  RigidPoints points_;
  RigidRows prolongation_;
  RigidColumns columns_;  // of the prolongation
  BlockMatrix matrix_;
};

}  // namespace kinetostat::fea
