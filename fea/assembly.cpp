#include "kinetostat/fea/assembly.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace kinetostat::fea {
namespace {

constexpr const char* phase = "assembly";

// The blocks of unknowns that an element touches, ascending.
void blocks_of(std::span<const int> element, const Unknowns& unknowns, std::vector<int>& blocks) {
  blocks.clear();
  for (const int node : element) {
    if (unknowns.is_fixed(node)) continue;
    if (const int body = unknowns.body_of(node); body >= 0) {
      blocks.push_back(unknowns.body_block(static_cast<std::size_t>(body)));
      blocks.push_back(blocks.back() + 1);
    } else {
      blocks.push_back(unknowns.block_of(node));
    }
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
}

// Items grouped by owner: those of owner i are item[start[i]] to item[start[i + 1] - 1].
struct Groups {
  std::vector<int> start, item;
};

Groups elements_of_blocks(const TetMesh& mesh, const Unknowns& unknowns) {
  Groups groups{std::vector<int>(static_cast<std::size_t>(unknowns.blocks()) + 1, 0), {}};
  std::vector<int> blocks;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    blocks_of(mesh.element(e), unknowns, blocks);
    for (const int b : blocks) ++groups.start[static_cast<std::size_t>(b) + 1];
  }
  for (std::size_t b = 1; b < groups.start.size(); ++b) groups.start[b] += groups.start[b - 1];
  groups.item.resize(static_cast<std::size_t>(groups.start.back()));
  std::vector<int> next(groups.start.begin(), groups.start.end() - 1);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    blocks_of(mesh.element(e), unknowns, blocks);
    for (const int b : blocks)
      groups.item[static_cast<std::size_t>(next[static_cast<std::size_t>(b)]++)] =
          static_cast<int>(e);
  }
  return groups;
}

BlockPattern find_pattern(const TetMesh& mesh, const Unknowns& unknowns) {
  const Groups elements = elements_of_blocks(mesh, unknowns);
  BlockPattern pattern;
  pattern.start.reserve(static_cast<std::size_t>(unknowns.blocks()) + 1);
  std::vector<int> seen_by(static_cast<std::size_t>(unknowns.blocks()), -1);
  std::vector<int> blocks, column;
  for (int b = 0; b < unknowns.blocks(); ++b) {
    column.assign(1, b);
    seen_by[static_cast<std::size_t>(b)] = b;
    for (int k = elements.start[static_cast<std::size_t>(b)];
         k < elements.start[static_cast<std::size_t>(b) + 1]; ++k) {
      const auto e = static_cast<std::size_t>(elements.item[static_cast<std::size_t>(k)]);
      blocks_of(mesh.element(e), unknowns, blocks);
      for (const int partner : blocks) {
        if (partner < b || seen_by[static_cast<std::size_t>(partner)] == b) continue;
        seen_by[static_cast<std::size_t>(partner)] = b;
        column.push_back(partner);
      }
    }
    std::sort(column.begin(), column.end());
    pattern.partner.insert(pattern.partner.end(), column.begin(), column.end());
    pattern.start.push_back(static_cast<int>(pattern.partner.size()));
  }
  return pattern;
}

// Column 3b + a of the matrix: rows a to 2 of the diagonal block, then three rows per partner.
SymmetricMatrix empty_matrix(const BlockPattern& pattern) {
  SymmetricMatrix matrix;
  const std::size_t entries = 9 * pattern.partner.size();
  if (entries > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::length_error("the stiffness matrix has more than 2^31 entries");
  matrix.row.reserve(entries);
  for (int b = 0; b < pattern.blocks(); ++b) {
    const int first = pattern.start[static_cast<std::size_t>(b)];
    const int last = pattern.start[static_cast<std::size_t>(b) + 1];
    for (int a = 0; a < 3; ++a) {
      for (int i = a; i < 3; ++i) matrix.row.push_back(3 * b + i);
      for (int k = first + 1; k < last; ++k)
        for (int i = 0; i < 3; ++i)
          matrix.row.push_back(3 * pattern.partner[static_cast<std::size_t>(k)] + i);
      matrix.column_start.push_back(static_cast<int>(matrix.row.size()));
    }
  }
  matrix.value.assign(matrix.row.size(), 0.0);
  return matrix;
}

void add_block(const BlockPattern& pattern, SymmetricMatrix& matrix, int row_block,
               int column_block, const Eigen::Ref<const Matrix3>& block) {
  const auto first =
      pattern.partner.begin() + pattern.start[static_cast<std::size_t>(column_block)];
  const auto last =
      pattern.partner.begin() + pattern.start[static_cast<std::size_t>(column_block) + 1];
  const auto place = static_cast<int>(std::lower_bound(first, last, row_block) - first);
  for (int a = 0; a < 3; ++a) {
    double* column =
        matrix.value.data() + matrix.column_start[static_cast<std::size_t>(3 * column_block + a)];
    if (place == 0) {
      for (int i = a; i < 3; ++i) column[i - a] += block(i, a);
    } else {
      double* at = column + (3 - a) + 3 * (place - 1);
      for (int i = 0; i < 3; ++i) at[i] += block(i, a);
    }
  }
}

// How the nodes of one element move with its blocks of unknowns: u = motion * unknowns.
Eigen::MatrixXd motion_of(const TetMesh& mesh, std::span<const int> element,
                          const Unknowns& unknowns, const std::vector<int>& blocks) {
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(element.size()),
                                                 3 * static_cast<Eigen::Index>(blocks.size()));
  const auto column = [&blocks](int block) {
    return 3 * (std::lower_bound(blocks.begin(), blocks.end(), block) - blocks.begin());
  };
  for (std::size_t n = 0; n < element.size(); ++n) {
    const int node = element[n];
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(n);
    if (unknowns.is_fixed(node)) continue;
    if (const int body = unknowns.body_of(node); body >= 0) {
      const auto b = static_cast<std::size_t>(body);
      motion.block<3, 6>(row, column(unknowns.body_block(b))) =
          rigid_motion(mesh.nodes[static_cast<std::size_t>(node)] - unknowns.bodies()[b].point);
    } else {
      motion.block<3, 3>(row, column(unknowns.block_of(node))).setIdentity();
    }
  }
  return motion;
}

// Adds element stiffnesses to the global one.
class Scatter {
 public:
  Scatter(const TetMesh& mesh, const Unknowns& unknowns, Equations& equations)
      : mesh_(mesh), unknowns_(unknowns), equations_(equations) {}

  template <int Nodes>
  void add(std::size_t e, const ElementStiffness<Nodes>& stiffness) {
    const auto element = mesh_.element(e);
    const bool follows_body = std::any_of(
        element.begin(), element.end(), [this](int node) { return unknowns_.body_of(node) >= 0; });
    if (follows_body)
      add_through_motion(element, stiffness);
    else
      add_directly<Nodes>(element, stiffness);
  }

 private:
  template <int Nodes>
  void add_directly(std::span<const int> element, const ElementStiffness<Nodes>& stiffness) {
    for (int j = 0; j < Nodes; ++j) {
      const int column = unknowns_.block_of(element[static_cast<std::size_t>(j)]);
      if (column < 0) continue;
      for (int i = 0; i < Nodes; ++i) {
        const int row = unknowns_.block_of(element[static_cast<std::size_t>(i)]);
        if (row >= column)
          add_block(equations_.pattern, equations_.stiffness, row, column,
                    stiffness.template block<3, 3>(3 * i, 3 * j));
      }
    }
  }

  void add_through_motion(std::span<const int> element,
                          const Eigen::Ref<const Eigen::MatrixXd>& stiffness) {
    blocks_of(element, unknowns_, blocks_);
    const Eigen::MatrixXd motion = motion_of(mesh_, element, unknowns_, blocks_);
    const Eigen::MatrixXd reduced = motion.transpose() * stiffness * motion;
    for (std::size_t j = 0; j < blocks_.size(); ++j)
      for (std::size_t i = j; i < blocks_.size(); ++i)
        add_block(equations_.pattern, equations_.stiffness, blocks_[i], blocks_[j],
                  reduced.block<3, 3>(3 * static_cast<Eigen::Index>(i),
                                      3 * static_cast<Eigen::Index>(j)));
  }

  const TetMesh& mesh_;
  const Unknowns& unknowns_;
  Equations& equations_;
  std::vector<int> blocks_;
};

}  // namespace

Unknowns::Unknowns(const TetMesh& mesh, const std::vector<int>& fixed_nodes,
                   std::vector<ReferenceBody> bodies)
    : master_(mesh.nodes.size(), free), block_(mesh.nodes.size(), -1), bodies_(std::move(bodies)) {
  for (const int node : fixed_nodes) master_[static_cast<std::size_t>(node)] = fixed;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for (const int node : bodies_[b].nodes) {
      int& master = master_[static_cast<std::size_t>(node)];
      if (master != free)
        throw std::invalid_argument(fmt::format("node {} belongs to two interfaces", node));
      master = static_cast<int>(b);
    }
  for (std::size_t n = 0; n < master_.size(); ++n)
    if (master_[n] == free) block_[n] = node_blocks_++;
}

Eigen::Matrix3Xd Unknowns::displacements(const TetMesh& mesh, const Eigen::VectorXd& values) const {
  Eigen::Matrix3Xd u(3, static_cast<Eigen::Index>(mesh.nodes.size()));
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    auto column = u.col(static_cast<Eigen::Index>(n));
    if (master_[n] == fixed) {
      column.setZero();
    } else if (master_[n] == free) {
      column = values.segment<3>(3 * block_[n]);
    } else {
      const auto b = static_cast<std::size_t>(master_[n]);
      column =
          rigid_motion(mesh.nodes[n] - bodies_[b].point) * values.segment<6>(3 * body_block(b));
    }
  }
  return u;
}

Equations assemble(const TetMesh& mesh, const std::vector<Material>& materials,
                   const Unknowns& unknowns, files::Progress& progress) {
  progress.report(phase, 0);
  Equations equations;
  equations.pattern = find_pattern(mesh, unknowns);
  equations.stiffness = empty_matrix(equations.pattern);
  Scatter scatter(mesh, unknowns, equations);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (e % 8192 == 0)
      progress.report(phase, static_cast<double>(e) / static_cast<double>(mesh.element_count()));
    const Material& material = materials[mesh.material_of(e)];
    if (mesh.curved)
      scatter.add<10>(e, stiffness_curved_tet10(mesh.all_nodes(e), material));
    else if (mesh.order == 2)
      scatter.add<10>(e, stiffness_tet10(mesh.corners(e), material));
    else
      scatter.add<4>(e, stiffness_tet4(mesh.corners(e), material));
  }
  for (const GroundSpring& spring : unknowns.springs()) {
    const int block = unknowns.block_of(spring.node);
    add_block(equations.pattern, equations.stiffness, block, block, spring.stiffness);
  }
  return equations;
}

}  // namespace kinetostat::fea
