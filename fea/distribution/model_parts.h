// A model divided among processes: each has some of the unknowns, and the elements that touch them.
#pragma once

#include <array>
#include <vector>

#include "kinetostat/fea/elasticity/assembly.h"

namespace kinetostat::fea {

/// Numbers of the blocks of unknowns of one level in all processes together, and which of them are
/// those of this part: `first` to `end` - 1, of nodes before `first_of_bodies` and of reference
/// bodies from there on.
struct BlockNumbers {
  int first = 0, first_of_bodies = 0, end = 0;
  std::vector<int> of_nodes;   // of the blocks of the part's free nodes in turn, ascending
  std::vector<int> of_bodies;  // of the first block of each body

  int own() const { return end - first; }
  bool is_own(int number) const { return number >= first && number < end; }
  /// Number of a block of the part's DofMap.
  int of_block(int block) const;
  /// First of the own nodes among the blocks of the part's DofMap.
  int first_block() const;
};

/// What a process needs to make its rows of the matrices: every element that touches its unknowns,
/// so that these rows are whole. Elements at a border are in several parts.
struct ModelPart {
  TetMesh mesh;          // [m], without boundary faces
  DofMap unknowns;       // of BlockOrder::as_nodes; all bodies, with those nodes that the mesh has
  BlockNumbers fine;     // of these unknowns
  BlockNumbers corners;  // of those of p1_coarse_space(mesh, unknowns)
};

/// The division of a whole model. A node goes where its corner goes; a middle node, where one of
/// the ends of its edge does; a reference body, where most of its nodes are. Keeps references to
/// the mesh and the unknowns.
class ModelDivision {
 public:
  /// Requires order 2, no contacts, and parts >= 1. Throws std::invalid_argument when a free node
  /// belongs to no element.
  ModelDivision(const TetMesh& mesh, const DofMap& unknowns, int parts);

  /// The first block of each part in the numbering by parts, then the number of all blocks.
  const std::vector<int>& first_blocks() const { return fine_.first; }
  int corner_blocks() const { return corners_.first.back(); }
  /// The DofMap's blocks in the order of the numbering by parts.
  std::vector<int> blocks_in_order() const;
  ModelPart part(int number) const;

 private:
  // The numbering by parts of one level.
  struct Level {
    std::vector<int> of_node;                 // -1: the node has no unknowns of its own
    std::vector<int> of_body;                 // first of two
    std::vector<int> first, first_of_bodies;  // of each part
  };

  std::vector<int> parts_of_nodes(const std::vector<std::array<int, 2>>& ends) const;
  std::vector<int> parts_of_bodies(const std::vector<int>& part) const;
  Level number(const std::vector<int>& nodes, const std::vector<int>& part,
               const std::vector<int>& body_part) const;
  std::vector<int> elements_of(int number) const;
  std::vector<int> nodes_of(const std::vector<int>& elements) const;
  static BlockNumbers numbers_of(const Level& level, int number, const std::vector<int>& nodes);

  const TetMesh& mesh_;
  const DofMap& unknowns_;
  int parts_;
  std::vector<int> owner_;  // of the unknowns with which each node moves; -1: it is fixed
  Level fine_, corners_;
};

}  // namespace kinetostat::fea
