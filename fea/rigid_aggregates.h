// Groups of neighbouring points that may move as rigid bodies.
#pragma once

#include <algorithm>
#include <vector>

#include "kinetostat/fea/assembly.h"
#include "kinetostat/fea/block_matrix.h"

namespace kinetostat::fea {

/// Blocks of unknowns of a level: a displacement of each point, or a displacement and a rotation;
/// behind them all, both of each reference body.
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

/// Points that are strongly linked in one group each: its number, in the order of the points, or
/// -1 for points that have no neighbours to speak of. Bodies are groups of their own, the last
/// ones.
std::vector<int> rigid_aggregates(const BlockMatrix& matrix, const RigidPoints& points);

}  // namespace kinetostat::fea
