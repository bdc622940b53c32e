// The same solid with linear displacements in each element: the coarse level of p-multigrid.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"
#include "kinetostat/fea/linear_algebra/rigid_aggregates.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// The ends of the edge that each node lies on; a corner is both its ends itself. {-1, -1} for a
/// node of no element. Requires order 2.
std::vector<std::array<int, 2>> edge_ends(const TetMesh& mesh);

/// A mesh of second order without its middle nodes, held and rigid where the whole one is. Because
/// the elements have straight edges, its displacements are among those of the whole mesh, and its
/// stiffness is P'KP with P of `Prolongation`.
struct P1CoarseSpace {
  TetMesh mesh;
  DofMap unknowns;
};

/// Requires order 2.
P1CoarseSpace p1_coarse_space(const TetMesh& mesh, const DofMap& unknowns);

/// P: the displacements of the corners as those of all nodes; a middle node moves with half the
/// sum of the ends of its edge.
class Prolongation {
 public:
  Prolongation(const TetMesh& mesh, const DofMap& fine, const DofMap& coarse);

  int coarse_blocks() const { return static_cast<int>(child_start_.size()) - 1; }
  std::size_t bytes() const {
    return sizeof(int) * (parent_.size() + child_start_.size() + child_.size()) +
           sizeof(BodyLink) * body_links_.size();
  }
  /// Calls visit(fine block, coarse block, factor) for the parts of P, some more than once: they
  /// add up.
  void visit_parts(const std::function<void(int, int, const Matrix3&)>& visit) const;

  /// fine = P coarse.
  void prolong(const MultiVector& coarse, MultiVector& fine, common::ThreadPool& pool) const;
  /// coarse = P' fine.
  void restrict(const MultiVector& fine, MultiVector& coarse, common::ThreadPool& pool) const;

 private:
  // Half the motion of a reference body, at a free node in the middle of an edge that ends on it.
  struct BodyLink {
    int block, body_block;  // fine, first coarse
    Eigen::Matrix<double, 3, 6> half_motion;
  };

  // Two for each fine block: coarse blocks of which it takes one half, or -1.
  std::vector<int> parent_;
  std::vector<BodyLink> body_links_;
  // The fine blocks that take one half of each coarse one.
  std::vector<int> child_start_, child_;
};

/// The points of a model of first order, for aggregation.
RigidPoints rigid_points(const TetMesh& mesh, const DofMap& unknowns);

}  // namespace kinetostat::fea
