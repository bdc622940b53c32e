#include "kinetostat/fea/elasticity/assembly.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/contact_stiffness.h"
#include "kinetostat/fea/elasticity/element_mass.h"
#include "kinetostat/fea/elasticity/groups.h"

namespace kinetostat::fea {
namespace {

using common::at;

// The blocks of unknowns that an element touches, ascending.
void blocks_of(std::span<const int> element, const DofMap& unknowns, std::vector<int>& blocks) {
  blocks.clear();
  for (const int node : element) {
    if (unknowns.is_fixed(node)) continue;
    if (const int body = unknowns.body_of(node); body >= 0) {
      blocks.push_back(unknowns.body_block(at(body)));
      blocks.push_back(blocks.back() + 1);
    } else {
      blocks.push_back(unknowns.block_of(node));
    }
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
}

// What has a stiffness of its own: the elements, and behind them the contacts of the mesh.
std::size_t part_count(const TetMesh& mesh) { return mesh.element_count() + mesh.contacts.size(); }

// The blocks of unknowns that element or contact e touches, ascending.
void blocks_of(const TetMesh& mesh, std::size_t e, const DofMap& unknowns,
               std::vector<int>& blocks) {
  if (e < mesh.element_count())
    blocks_of(mesh.element(e), unknowns, blocks);
  else
    blocks_of(contact_nodes(mesh, mesh.contacts[e - mesh.element_count()]), unknowns, blocks);
}

Groups elements_of_blocks(const TetMesh& mesh, const DofMap& unknowns) {
  std::vector<int> blocks;
  return group(at(unknowns.blocks()), part_count(mesh),
               [&](std::size_t e) -> const std::vector<int>& {
                 blocks_of(mesh, e, unknowns, blocks);
                 return blocks;
               });
}

// Which part of the matrix is made: rows first to end - 1; whole, or from the diagonal on.
struct Part {
  int first, end;
  bool whole;
};

// Rows of blocks that one thread works on at a time.
constexpr int rows_at_once = 4096;

int pieces(const Part& part) { return (part.end - part.first + rows_at_once - 1) / rows_at_once; }

Part piece_of(const Part& part, int piece) {
  const int first = part.first + piece * rows_at_once;
  return {first, std::min(first + rows_at_once, part.end), part.whole};
}

BlockPattern rows_of_pattern(const TetMesh& mesh, const DofMap& unknowns, const Groups& elements,
                             const Part& part) {
  BlockPattern rows;
  std::vector<int> blocks, row;
  for (int b = part.first; b < part.end; ++b) {
    row.assign(1, b);
    for (int k = elements.start[at(b)]; k < elements.start[at(b) + 1]; ++k) {
      blocks_of(mesh, at(elements.item[at(k)]), unknowns, blocks);
      row.insert(row.end(),
                 part.whole ? blocks.begin() : std::upper_bound(blocks.begin(), blocks.end(), b),
                 blocks.end());
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    rows.partner.insert(rows.partner.end(), row.begin(), row.end());
    rows.start.push_back(static_cast<int>(rows.partner.size()));
  }
  return rows;
}

// How the nodes of one element move with its blocks of unknowns: u = motion * unknowns.
Eigen::MatrixXd motion_of(const TetMesh& mesh, std::span<const int> element, const DofMap& unknowns,
                          const std::vector<int>& blocks) {
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
      const auto b = at(body);
      motion.block<3, 6>(row, column(unknowns.body_block(b))) =
          spatial::rigid_motion(mesh.nodes[at(node)] - unknowns.bodies()[b].point);
    } else {
      motion.block<3, 3>(row, column(unknowns.block_of(node))).setIdentity();
    }
  }
  return motion;
}

// Adds element matrices to some rows of the global matrix.
class Scatter {
 public:
  // `matrix` starts with the row `first_row`.
  Scatter(const TetMesh& mesh, const DofMap& unknowns, const Part& rows, int first_row,
          BlockMatrix& matrix)
      : mesh_(mesh), unknowns_(unknowns), rows_(rows), first_row_(first_row), matrix_(matrix) {}

  // Between the displacements of these nodes.
  template <class Matrix>
  void add(std::span<const int> nodes, const Matrix& stiffness) {
    const bool follows_body = std::any_of(
        nodes.begin(), nodes.end(), [this](int node) { return unknowns_.body_of(node) >= 0; });
    if (follows_body)
      add_through_motion(nodes, stiffness);
    else
      add_directly(nodes, stiffness);
  }

  void add_block(int row, int column, const Eigen::Ref<const Matrix3>& block) {
    if (row < rows_.first || row >= rows_.end) return;
    const int r = row - first_row_;
    const auto begin = matrix_.pattern.partner.begin();
    const auto at =
        std::lower_bound(begin + static_cast<std::ptrdiff_t>(matrix_.pattern.begin(r)),
                         begin + static_cast<std::ptrdiff_t>(matrix_.pattern.end(r)), column);
    double* value = matrix_.value.data() + 9 * (at - begin);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) *value++ += block(i, j);
  }

 private:
  template <class Matrix>
  void add_directly(std::span<const int> nodes, const Matrix& stiffness) {
    const int count = static_cast<int>(nodes.size());
    for (int i = 0; i < count; ++i) {
      const int row = unknowns_.block_of(nodes[at(i)]);
      if (row < rows_.first || row >= rows_.end) continue;
      for (int j = 0; j < count; ++j) {
        const int column = unknowns_.block_of(nodes[at(j)]);
        if (column >= row || (rows_.whole && column >= 0))
          add_block(row, column, stiffness.template block<3, 3>(3 * i, 3 * j));
      }
    }
  }

  void add_through_motion(std::span<const int> element,
                          const Eigen::Ref<const Eigen::MatrixXd>& stiffness) {
    blocks_of(element, unknowns_, blocks_);
    const Eigen::MatrixXd motion = motion_of(mesh_, element, unknowns_, blocks_);
    const Eigen::MatrixXd reduced = motion.transpose() * stiffness * motion;
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      for (std::size_t j = rows_.whole ? 0 : i; j < blocks_.size(); ++j)
        add_block(blocks_[i], blocks_[j],
                  reduced.block<3, 3>(3 * static_cast<Eigen::Index>(i),
                                      3 * static_cast<Eigen::Index>(j)));
  }

  const TetMesh& mesh_;
  const DofMap& unknowns_;
  Part rows_;
  int first_row_;
  BlockMatrix& matrix_;
  std::vector<int> blocks_;
};

// Elements that touch the given rows, ascending.
std::vector<int> elements_of_rows(const Groups& elements, const Part& rows) {
  std::vector<int> some(elements.item.begin() + elements.start[at(rows.first)],
                        elements.item.begin() + elements.start[at(rows.end)]);
  std::sort(some.begin(), some.end());
  some.erase(std::unique(some.begin(), some.end()), some.end());
  return some;
}

// Which matrix of the elements is summed.
enum class Integral { stiffness, mass };

void add_stiffness(const TetMesh& mesh, std::size_t e, const Material& material, Scatter& scatter) {
  if (mesh.curved)
    scatter.add(mesh.element(e), stiffness_curved_tet10(mesh.all_nodes(e), material));
  else if (mesh.order == 2)
    scatter.add(mesh.element(e), stiffness_tet10(mesh.corners(e), material));
  else
    scatter.add(mesh.element(e), stiffness_tet4(mesh.corners(e), material));
}

template <int Nodes>
ElementStiffness<Nodes> in_each_direction(const Eigen::MatrixXd& mass) {
  ElementStiffness<Nodes> all = ElementStiffness<Nodes>::Zero();
  for (int j = 0; j < Nodes; ++j)
    for (int i = 0; i < Nodes; ++i)
      all.template block<3, 3>(3 * i, 3 * j).diagonal().setConstant(mass(i, j));
  return all;
}

void add_mass(const TetMesh& mesh, std::size_t e, const Material& material, Scatter& scatter) {
  if (!material.density()) return;
  const Eigen::MatrixXd mass = *material.density() * shape_products(mesh, e);
  if (mesh.order == 2)
    scatter.add(mesh.element(e), in_each_direction<10>(mass));
  else
    scatter.add(mesh.element(e), in_each_direction<4>(mass));
}

void add_rows(const TetMesh& mesh, const std::vector<Material>& materials, const DofMap& unknowns,
              Integral integral, const Groups& elements, const Part& rows, int first_row,
              BlockMatrix& matrix) {
  Scatter scatter(mesh, unknowns, rows, first_row, matrix);
  const auto add = integral == Integral::mass ? add_mass : add_stiffness;
  for (const int element : elements_of_rows(elements, rows)) {
    const std::size_t e = at(element);
    if (e < mesh.element_count()) {
      add(mesh, e, materials[mesh.material_of(e)], scatter);
    } else if (integral == Integral::stiffness) {
      const FaceContact& contact = mesh.contacts[e - mesh.element_count()];
      scatter.add(contact_nodes(mesh, contact), contact_stiffness(mesh, materials, contact));
    }
  }
  if (integral == Integral::mass) return;
  for (const GroundSpring& spring : unknowns.springs()) {
    const int block = unknowns.block_of(spring.node);
    scatter.add_block(block, block, spring.stiffness);
  }
}

BlockPattern find_pattern(const TetMesh& mesh, const DofMap& unknowns, const Groups& elements,
                          const Part& part, common::ThreadPool& pool) {
  std::vector<BlockPattern> rows(at(pieces(part)));
  pool.for_each(pieces(part), [&](int piece) {
    rows[at(piece)] = rows_of_pattern(mesh, unknowns, elements, piece_of(part, piece));
  });
  std::size_t partners = 0;
  for (const BlockPattern& some : rows) partners += some.partner.size();
  BlockPattern pattern;
  pattern.partner.reserve(partners);
  for (BlockPattern& some : rows) append(pattern, std::exchange(some, {}));
  return pattern;
}

BlockMatrix assemble_part(const TetMesh& mesh, const std::vector<Material>& materials,
                          const DofMap& unknowns, Integral integral, const Part& part,
                          common::ThreadPool& pool, common::Progress& progress) {
  progress.report("assembly", 0);
  const Groups elements = elements_of_blocks(mesh, unknowns);
  BlockMatrix matrix{.pattern = find_pattern(mesh, unknowns, elements, part, pool)};
  progress.report("assembly", 0.3);
  matrix.value.assign(9 * matrix.pattern.partner.size(), 0.0);
  pool.for_each(pieces(part), [&](int piece) {
    if (!progress.cancelled())
      add_rows(mesh, materials, unknowns, integral, elements, piece_of(part, piece), part.first,
               matrix);
  });
  progress.report("assembly", 1);
  return matrix;
}

}  // namespace

DofMap::DofMap(const TetMesh& mesh, const std::vector<int>& fixed_nodes,
               std::vector<ReferenceBody> bodies, BlockOrder order)
    : master_(mesh.nodes.size(), free),
      block_(mesh.nodes.size(), -1),
      bodies_(std::move(bodies)),
      order_(order) {
  for (const int node : fixed_nodes) master_[at(node)] = fixed;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for (const int node : bodies_[b].nodes) {
      int& master = master_[at(node)];
      if (master != free)
        throw std::invalid_argument(fmt::format("node {} belongs to two interfaces", node));
      master = static_cast<int>(b);
    }
  const auto count = [this](std::size_t n) {
    if (master_[n] == free) block_[n] = node_blocks_++;
  };
  if (order == BlockOrder::as_nodes)
    for (std::size_t n = 0; n < block_.size(); ++n) count(n);
  else
    for (const int node : along_curve(mesh.nodes)) count(at(node));
}

Eigen::Matrix3Xd DofMap::displacements(const TetMesh& mesh, const Eigen::VectorXd& values) const {
  Eigen::Matrix3Xd u(3, static_cast<Eigen::Index>(mesh.nodes.size()));
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    auto column = u.col(static_cast<Eigen::Index>(n));
    if (master_[n] == fixed) {
      column.setZero();
    } else if (master_[n] == free) {
      column = values.segment<3>(Eigen::Index{3} * block_[n]);
    } else {
      const auto b = at(master_[n]);
      column = spatial::rigid_motion(mesh.nodes[n] - bodies_[b].point) *
               values.segment<6>(Eigen::Index{3} * body_block(b));
    }
  }
  return u;
}

BlockMatrix assemble(const TetMesh& mesh, const std::vector<Material>& materials,
                     const DofMap& unknowns, common::ThreadPool& pool, common::Progress& progress) {
  return assemble_part(mesh, materials, unknowns, Integral::stiffness,
                       {0, unknowns.blocks(), false}, pool, progress);
}

BlockMatrix assemble_mass(const TetMesh& mesh, const std::vector<Material>& materials,
                          const DofMap& unknowns, common::ThreadPool& pool,
                          common::Progress& progress) {
  return assemble_part(mesh, materials, unknowns, Integral::mass, {0, unknowns.blocks(), false},
                       pool, progress);
}

BlockPattern find_rows(const TetMesh& mesh, const DofMap& unknowns, int first, int end,
                       common::ThreadPool& pool) {
  return find_pattern(mesh, unknowns, elements_of_blocks(mesh, unknowns), {first, end, true}, pool);
}

BlockMatrix assemble_rows(const TetMesh& mesh, const std::vector<Material>& materials,
                          const DofMap& unknowns, int first, int end, common::ThreadPool& pool,
                          common::Progress& progress) {
  return assemble_part(mesh, materials, unknowns, Integral::stiffness, {first, end, true}, pool,
                       progress);
}

}  // namespace kinetostat::fea
