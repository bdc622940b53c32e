#include "kinetostat/fea/linear_algebra/aggregate_level.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"
#include "kinetostat/fea/linear_algebra/aggregation_multigrid.h"

#include "fea/shapes.h"

namespace kinetostat::fea::aggregate_level_test {
namespace {

const Material steel(210e9, 0.3);

TetMesh block_mesh() { return box_mesh({0.4, 0.15, 0.15}, 16, 6, 6); }  // cells of 25 mm

// Elements of first order, one end glued to a body.
struct Block {
  TetMesh mesh;
  DofMap unknowns;
  RigidPoints points;
  common::ThreadPool pool{3};
  common::Progress silent;
  BlockMatrix matrix;

  explicit Block(TetMesh of = block_mesh(), const std::vector<int>& fixed = {},
                 const std::vector<Material>& materials = {steel})
      : mesh(std::move(of)),
        unknowns(mesh, fixed, {{Vector3(0.5, 0.02, 0.1), interface_on(mesh, 2).nodes}}),
        points(rigid_points(mesh, unknowns)),
        matrix(assemble(mesh, materials, unknowns, pool, silent)) {}
};

// What the unknowns of a level are when all moves as one rigid body.
Eigen::VectorXd rigid(const RigidPoints& points, const Eigen::Matrix<double, 6, 1>& motion) {
  Eigen::VectorXd values(3 * points.blocks());
  for (int p = 0; p < points.size(); ++p) {
    const int block = points.first_block(p);
    values.segment<3>(3 * block) =
        spatial::rigid_motion(points.points[static_cast<std::size_t>(p)]) * motion;
    if (points.blocks_of(p) == 2)
      values.segment<3>(3 * block + 3) = points.length * motion.tail<3>();
  }
  return values;
}

Eigen::VectorXd prolonged(const AggregateLevel& level, const Eigen::VectorXd& coarse,
                          Eigen::Index size) {
  MultiVector fine(static_cast<std::size_t>(size));
  level.prolong(to_multi_vector(coarse), fine);
  Eigen::VectorXd values(size);
  from_multi_vector(fine, values);
  return values;
}

TEST(RigidAggregates, EveryPointIsInAGroupOfNeighboursAndEveryBodyInItsOwn) {
  const Block block;
  const std::vector<int> group = rigid_aggregates(block.matrix, block.points);
  const int groups = group.back() + 1;
  EXPECT_EQ(std::count(group.begin(), group.end(), groups - 1), 1);  // the body
  EXPECT_GE(*std::min_element(group.begin(), group.end()), 0);
  EXPECT_LT(groups, block.points.size() / 6);
  for (int g = 0; g + 1 < groups; ++g) {
    std::vector<Vector3> members;
    for (std::size_t p = 0; p < group.size(); ++p)
      if (group[p] == g) members.push_back(block.points.points[p]);
    EXPECT_GE(members.size(), 3u);
    EXPECT_LT(bounding_box(members).diagonal().norm(), 5 * std::sqrt(3) * 0.025);
  }
}

TEST(RigidAggregates, StiffAndSoftPointsAreNotInOneGroup) {
  TetMesh mesh = block_mesh();
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    double x = 0;
    for (const Vector3& p : mesh.corners(e)) x += p.x() / 4;
    mesh.materials.push_back(x > 0.2 ? 1 : 0);
  }
  const Block block(mesh, {}, {steel, Material(210e14, 0.3)});
  const std::vector<int> group = rigid_aggregates(block.matrix, block.points);
  std::set<int> soft, stiff;
  for (int p = 0; p < block.points.nodes(); ++p)
    (block.points.points[static_cast<std::size_t>(p)].x() < 0.199 ? soft : stiff)
        .insert(group[static_cast<std::size_t>(p)]);
  for (const int g : soft) EXPECT_EQ(stiff.count(g), 0u);
}

TEST(RigidAggregates, PointsThatNothingLinksAreInNoGroup) {
  // Three points, each held by itself.
  BlockMatrix apart{.pattern = {.start = {0, 1, 2, 3}, .partner = {0, 1, 2}}};
  for (int b = 0; b < 3; ++b)
    for (const double entry : {2., 0., 0., 0., 2., 0., 0., 0., 2.}) apart.value.push_back(entry);
  const RigidPoints points{.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  EXPECT_THAT(rigid_aggregates(apart, points), testing::Each(-1));
}

// Without a support A annihilates rigid motions, and smoothing leaves them as they are.
TEST(AggregateLevel, MovesWithEveryRigidMotionOverTwoLevels) {
  Block block;
  AggregateLevel first(block.matrix, block.points, 2.5, block.pool);
  AggregateLevel second(first.matrix(), first.points(), 2.5, block.pool);
  for (int k = 0; k < 6; ++k) {
    const auto motion = Eigen::Matrix<double, 6, 1>::Unit(k);
    const Eigen::VectorXd fine = rigid(block.points, motion),
                          middle = rigid(first.points(), motion),
                          coarse = rigid(second.points(), motion);
    EXPECT_LT((prolonged(first, middle, fine.size()) - fine).norm(), 1e-12 * fine.norm()) << k;
    EXPECT_LT((prolonged(second, coarse, middle.size()) - middle).norm(), 1e-11 * middle.norm())
        << k;
  }
}

TEST(AggregateLevel, MatrixIsThatOfTheProlongedMotions) {
  const TetMesh mesh = block_mesh();
  Block block(mesh, interface_on(mesh, 1).nodes);
  const AggregateLevel level(block.matrix, block.points, 2.5, block.pool);
  const Eigen::Index size = level.matrix().size();
  const double scale = *std::max_element(level.matrix().value.begin(), level.matrix().value.end());
  MultiVectorProduct product(block.matrix, block.pool);
  MultiVector fine(static_cast<std::size_t>(block.matrix.size())), force(fine.size());
  MultiVector back(static_cast<std::size_t>(size));
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::VectorXd e = Eigen::VectorXd::Unit(size, j);
    level.prolong(to_multi_vector(e), fine);
    product(fine, force, [](int) {});
    level.restrict(force, back);
    Eigen::VectorXd column(size);
    from_multi_vector(back, column);
    const Eigen::VectorXd expected =
        -level.matrix().residual(Eigen::VectorXd::Zero(size), e).col(0);
    EXPECT_LT((column - expected).cwiseAbs().maxCoeff(), 1e-13 * scale) << j;
  }
}

// Conjugate gradients require it of a preconditioner.
TEST(AggregationMultigrid, IsSymmetricAndPositiveDefiniteAndNearTheInverse) {
  const TetMesh mesh = block_mesh();
  Block block(mesh, interface_on(mesh, 1).nodes);
  const BlockMatrix matrix = block.matrix;
  AggregationMultigrid multigrid(block.matrix, block.points, 1e4, block.pool, block.silent);
  EXPECT_GE(multigrid.unknowns().size(), 2u);
  multigrid.factorise();
  Eigen::MatrixXd b(matrix.size(), lane_count), x(b.rows(), b.cols());
  for (Eigen::Index i = 0; i < b.size(); ++i) b.data()[i] = std::sin(7.0 * double(i * i % 1013));
  MultiVector lanes(static_cast<std::size_t>(matrix.size()));
  multigrid.solve(to_multi_vector(b), lane_count, lanes);
  from_multi_vector(lanes, x);
  const Eigen::MatrixXd products = b.transpose() * x;
  EXPECT_LT((products - products.transpose()).norm(), 1e-12 * products.norm());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(products).eigenvalues().minCoeff(), 0);
  const Eigen::MatrixXd exact = Factorisation(matrix, 1).solve(b);
  const Eigen::MatrixXd error = x - exact;
  const auto energy = [&matrix](const Eigen::MatrixXd& u) {
    return -(u.transpose() * matrix.residual(Eigen::MatrixXd::Zero(u.rows(), u.cols()), u)).trace();
  };
  EXPECT_LT(energy(error), 0.0625 * energy(exact));  // a quarter, as a root
}

}  // namespace
}  // namespace kinetostat::fea::aggregate_level_test
