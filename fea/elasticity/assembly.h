// The equations of a supported, partly rigid solid: K u = f in the motions that are free.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/common/thread_pool.h"
#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/elasticity/reference_body.h"
#include "kinetostat/fea/linear_algebra/block_matrix.h"
#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// A spring between a node and the ground [N/m].
struct GroundSpring {
  int node = 0;
  Matrix3 stiffness;
};

/// The order of the free nodes' unknowns: along a space-filling curve, so that neighbours are near
/// in memory, or as the mesh has the nodes, where that was seen to before.
enum class BlockOrder { along_curve, as_nodes };

/// The degrees of freedom. Unknowns come in blocks of three: first the displacements of the free
/// nodes, then the translation and the rotation of each reference body.
class DofMap {
 public:
  /// Throws std::invalid_argument when a node has two masters, or is fixed and has one.
  DofMap(const TetMesh& mesh, const std::vector<int>& fixed_nodes,
         std::vector<ReferenceBody> bodies, BlockOrder order = BlockOrder::along_curve);

  BlockOrder order() const { return order_; }
  const std::vector<ReferenceBody>& bodies() const { return bodies_; }
  /// Springs belong to the equations: assemble() adds them. Requires free nodes.
  const std::vector<GroundSpring>& springs() const { return springs_; }
  void set_springs(std::vector<GroundSpring> springs) { springs_ = std::move(springs); }
  int node_blocks() const { return node_blocks_; }
  int blocks() const { return node_blocks_ + 2 * static_cast<int>(bodies_.size()); }
  /// First of the two blocks of a body.
  int body_block(std::size_t body) const { return node_blocks_ + 2 * static_cast<int>(body); }

  bool is_fixed(int node) const { return master_[static_cast<std::size_t>(node)] == fixed; }
  /// The body that the node follows, or -1.
  int body_of(int node) const { return std::max(master_[static_cast<std::size_t>(node)], -1); }
  /// Block of a free node, -1 for others.
  int block_of(int node) const { return block_[static_cast<std::size_t>(node)]; }

  /// The displacements of all nodes of the mesh, one column each [m], for values of the unknowns.
  Eigen::Matrix3Xd displacements(const TetMesh& mesh, const Eigen::VectorXd& values) const;

 private:
  static constexpr int free = -1, fixed = -2;
  std::vector<int> master_;  // free, fixed or the number of a body
  std::vector<int> block_;
  std::vector<ReferenceBody> bodies_;
  std::vector<GroundSpring> springs_;
  int node_blocks_ = 0;
  BlockOrder order_;
};

/// Assembles the stiffness of the free motions, T' K T with T the rigid motions. `materials` are
/// those that the elements name by number. Every entry is summed in the order of the elements, so
/// the number of threads changes no digit.
BlockMatrix assemble(const TetMesh& mesh, const std::vector<Material>& materials,
                     const DofMap& unknowns, common::ThreadPool& pool, common::Progress& progress);

/// The mass of the free motions, T' M T with the consistent mass M of the elements
/// (element_mass.h), in the pattern of the stiffness. Materials without a density have none.
BlockMatrix assemble_mass(const TetMesh& mesh, const std::vector<Material>& materials,
                          const DofMap& unknowns, common::ThreadPool& pool,
                          common::Progress& progress);

/// Whole rows of the stiffness, first to end - 1, with the blocks left of the diagonal: for a
/// process that holds these alone. Row `first` is row 0 of the result's pattern, whose partners are
/// in ascending order and numbers of the whole matrix.
BlockMatrix assemble_rows(const TetMesh& mesh, const std::vector<Material>& materials,
                          const DofMap& unknowns, int first, int end, common::ThreadPool& pool,
                          common::Progress& progress);

/// The links of these rows alone, without values.
BlockPattern find_rows(const TetMesh& mesh, const DofMap& unknowns, int first, int end,
                       common::ThreadPool& pool);

}  // namespace kinetostat::fea
