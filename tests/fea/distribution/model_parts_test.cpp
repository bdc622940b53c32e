#include "kinetostat/fea/distribution/model_parts.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"

#include "fea/shapes.h"
#include "support/matrix_near.h"

namespace kinetostat::fea::model_parts_test {
namespace {

using common::at;
using test::matrix_near_relative;

const std::vector<Material> materials{Material(210e9, 0.3), Material(70e9, 0.33)};

struct Bar {
  TetMesh mesh;
  DofMap unknowns;
};

// Of two materials. Some nodes of one end are fixed and others on springs; the other end follows a
// body.
Bar bar(int cells, double curvature = 0) {
  const double length = 0.05 * cells;
  TetMesh mesh = with_mid_nodes(box_mesh({length, 0.1, 0.1}, cells, 2, 2));
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    mesh.materials.push_back(mesh.corners(e)[0].x() < length / 2 ? 0 : 1);
  mesh.curved = curvature != 0;
  const auto ends = edge_ends(mesh);
  for (std::size_t n = 0; n < ends.size(); ++n)
    if (ends[n][0] != ends[n][1]) mesh.nodes[n] += curvature * Vector3(1, -1, 2);
  std::vector<int> fixed, sprung;
  for (const int node : interface_on(mesh, 1).nodes)
    (mesh.nodes[at(node)].y() < 0.06 ? fixed : sprung).push_back(node);
  DofMap unknowns(mesh, fixed, {{Vector3(length, 0.02, 0), interface_on(mesh, 2).nodes}});
  std::vector<GroundSpring> springs;
  for (const int node : sprung)
    springs.push_back({node, 1e8 * Vector3(1, 2, 3).asDiagonal().toDenseMatrix()});
  unknowns.set_springs(std::move(springs));
  return {std::move(mesh), std::move(unknowns)};
}

// Adds the own rows of a part to the matrix of all: those of nodes, then those of each body.
void add_rows(const TetMesh& mesh, const DofMap& unknowns, const BlockNumbers& numbers,
              Eigen::MatrixXd& all) {
  common::Progress silent;
  common::ThreadPool alone(1);
  const auto add = [&](int first, int end) {
    const BlockMatrix rows = assemble_rows(mesh, materials, unknowns, first, end, alone, silent);
    for (int r = 0; r < rows.pattern.blocks(); ++r)
      for (std::size_t k = rows.pattern.begin(r); k < rows.pattern.end(r); ++k)
        all.block<3, 3>(3 * numbers.of_block(first + r),
                        3 * numbers.of_block(rows.pattern.partner[k])) += rows.block(k);
  };
  add(numbers.first_block(), numbers.first_block() + numbers.first_of_bodies - numbers.first);
  for (std::size_t b = 0; b < unknowns.bodies().size(); ++b)
    if (numbers.is_own(numbers.of_bodies[b]))
      add(unknowns.body_block(b), unknowns.body_block(b) + 2);
}

// The stiffness as the parts make it, of all nodes and of the corners alone, and the prolongation.
struct Levels {
  Eigen::MatrixXd fine, corners, prolongation;
};

Levels levels_of(const ModelDivision& division, int parts) {
  const Eigen::Index fine = 3 * division.first_blocks().back();
  const Eigen::Index corner = 3 * division.corner_blocks();
  Levels levels{Eigen::MatrixXd::Zero(fine, fine), Eigen::MatrixXd::Zero(corner, corner),
                Eigen::MatrixXd::Zero(fine, corner)};
  for (int p = 0; p < parts; ++p) {
    const ModelPart part = division.part(p);
    const P1CoarseSpace corners = p1_coarse_space(part.mesh, part.unknowns);
    add_rows(part.mesh, part.unknowns, part.fine, levels.fine);
    add_rows(corners.mesh, corners.unknowns, part.corners, levels.corners);
    Prolongation(part.mesh, part.unknowns, corners.unknowns)
        .visit_parts([&](int row, int column, const Matrix3& factor) {
          if (part.fine.is_own(part.fine.of_block(row)))
            levels.prolongation.block<3, 3>(3 * part.fine.of_block(row),
                                            3 * part.corners.of_block(column)) += factor;
        });
  }
  return levels;
}

// In the numbering by parts.
Eigen::MatrixXd whole_stiffness(const Bar& model, const std::vector<int>& blocks) {
  common::Progress silent;
  common::ThreadPool alone(1);
  const int count = model.unknowns.blocks();
  const BlockMatrix k =
      assemble_rows(model.mesh, materials, model.unknowns, 0, count, alone, silent);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * count, 3 * count);
  for (int r = 0; r < count; ++r)
    for (std::size_t i = k.pattern.begin(r); i < k.pattern.end(r); ++i)
      dense.block<3, 3>(3 * r, 3 * k.pattern.partner[i]) = k.block(i);
  std::vector<Eigen::Index> order;
  for (const int block : blocks)
    for (int i = 0; i < 3; ++i) order.push_back(3 * block + i);
  return dense(order, order);
}

TEST(ModelParts, TheirRowsAreTheWholeStiffness) {
  for (const double curvature : {0.0, 0.001})
    for (const int parts : {1, 2, 3, 4}) {
      const Bar model = bar(8, curvature);
      const ModelDivision division(model.mesh, model.unknowns, parts);
      EXPECT_TRUE(matrix_near_relative(levels_of(division, parts).fine,
                                       whole_stiffness(model, division.blocks_in_order()), 1e-14))
          << parts << " parts, edges curved by " << curvature;
    }
}

// With straight edges the linear displacements are among the quadratic ones. The springs are not:
// they go to the ends of edges in equal shares.
TEST(ModelParts, TheirCornersAreTheWholeSeenThroughTheirProlongation) {
  for (const int parts : {1, 2, 3, 4}) {
    Bar model = bar(8);
    model.unknowns.set_springs({});
    const ModelDivision division(model.mesh, model.unknowns, parts);
    const Levels levels = levels_of(division, parts);
    const Eigen::MatrixXd expected =
        levels.prolongation.transpose() * levels.fine * levels.prolongation;
    EXPECT_TRUE(matrix_near_relative(levels.corners, expected, 1e-12)) << parts << " parts";
  }
}

TEST(ModelParts, HaveEvenSharesAndFewElementsTwice) {
  const Bar model = bar(40);
  constexpr int parts = 4;
  const ModelDivision division(model.mesh, model.unknowns, parts);
  const std::vector<int>& first = division.first_blocks();
  ASSERT_EQ(first.size(), at(parts) + 1);
  EXPECT_EQ(first.back(), model.unknowns.blocks());
  for (int p = 0; p < parts; ++p) {
    EXPECT_NEAR(first[at(p) + 1] - first[at(p)], first.back() / parts, 0.1 * first.back() / parts);
    EXPECT_LT(static_cast<double>(division.part(p).mesh.element_count()),
              0.35 * static_cast<double>(model.mesh.element_count()));
  }
}

// Some of them have nothing then.
TEST(ModelParts, OfASmallModelMayBeManyMoreThanItFills) {
  const Bar model = bar(2);
  constexpr int parts = 9;
  const ModelDivision division(model.mesh, model.unknowns, parts);
  std::vector<int> blocks = division.blocks_in_order(), all(blocks.size());
  std::sort(blocks.begin(), blocks.end());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(blocks, all);
  EXPECT_TRUE(matrix_near_relative(levels_of(division, parts).fine,
                                   whole_stiffness(model, division.blocks_in_order()), 1e-14));
  EXPECT_EQ(division.part(parts - 1).mesh.element_count(), 0u);
}

TEST(ModelParts, RefuseAFreeNodeWithoutAnElement) {
  Bar model = bar(2);
  model.mesh.nodes.emplace_back(1, 1, 1);
  const DofMap unknowns(model.mesh, {}, {});
  EXPECT_THROW(ModelDivision(model.mesh, unknowns, 2), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::fea::model_parts_test
