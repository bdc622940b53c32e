#include "kinetostat/fea/elasticity/assembly.h"

#include <gtest/gtest.h>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/linear_algebra/factorisation.h"

#include "fea/shapes.h"

namespace kinetostat::fea::assembly_test {
namespace {

const Material steel(210e9, 0.3);

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  return -matrix.residual(Eigen::MatrixXd::Zero(matrix.size(), matrix.size()),
                          Eigen::MatrixXd::Identity(matrix.size(), matrix.size()));
}

// The sum of all elements, entry by entry.
Eigen::MatrixXd summed(const TetMesh& mesh) {
  const auto size = 3 * static_cast<Eigen::Index>(mesh.nodes.size());
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto k = stiffness_tet10(mesh.corners(e), steel);
    const auto tet = mesh.element(e);
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 10; ++j)
        full.block<3, 3>(3 * tet[static_cast<std::size_t>(i)],
                         3 * tet[static_cast<std::size_t>(j)]) += k.block<3, 3>(3 * i, 3 * j);
  }
  return full;
}

// Column by column, how all nodes move with the unknowns.
Eigen::MatrixXd motions(const TetMesh& mesh, const DofMap& unknowns) {
  const Eigen::Index count = 3 * unknowns.blocks();
  Eigen::MatrixXd t(3 * static_cast<Eigen::Index>(mesh.nodes.size()), count);
  for (Eigen::Index j = 0; j < count; ++j)
    t.col(j) = unknowns.displacements(mesh, Eigen::VectorXd::Unit(count, j)).reshaped();
  return t;
}

TEST(Assembly, IsTheElementsSumSeenThroughTheFreeMotions) {
  common::Progress silent;
  common::ThreadPool pool(2);
  const TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 2, 1, 1));
  const DofMap unknowns(mesh, interface_on(mesh, 1).nodes,
                        {{Vector3(0.3, 0, 0.1), interface_on(mesh, 2).nodes}});
  const Eigen::MatrixXd t = motions(mesh, unknowns);
  const Eigen::MatrixXd expected = t.transpose() * summed(mesh) * t;
  const Eigen::MatrixXd k = dense(assemble(mesh, {steel}, unknowns, pool, silent));
  EXPECT_LT((k - expected).cwiseAbs().maxCoeff(), 1e-14 * expected.cwiseAbs().maxCoeff());
}

TEST(Assembly, SixRigidMotionsStoreNoEnergy) {
  common::Progress silent;
  common::ThreadPool pool(2);
  const TetMesh mesh = with_mid_nodes(box_mesh({0.31, 0.02, 0.012}, 10, 2, 2));
  const DofMap unknowns(mesh, {}, {});
  const BlockMatrix k = assemble(mesh, {steel}, unknowns, pool, silent);
  const double stiffness = *std::max_element(k.value.begin(), k.value.end());
  for (int motion = 0; motion < 6; ++motion) {
    Eigen::VectorXd u(k.size());
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      u.segment<3>(3 * unknowns.block_of(static_cast<int>(n))) =
          spatial::rigid_motion(mesh.nodes[n] - Vector3(0.15, 0, 0)).col(motion);
    const double energy = -0.5 * u.dot(k.residual(Eigen::VectorXd::Zero(k.size()), u).col(0));
    EXPECT_LT(std::abs(energy), 1e-15 * stiffness * u.squaredNorm()) << motion;
  }
}

// The patch test: boundary nodes moved by u = A x, all others must follow exactly.
TEST(Assembly, PatchTestIsPassedByBothElements) {
  common::Progress silent;
  common::ThreadPool pool(2);
  Matrix3 a;
  a << 3, -2, 7, 1, 5, -4, -6, 2, 9;
  a *= 1e-4;
  for (const int order : {1, 2}) {
    TetMesh mesh = box_mesh({0.3, 0.3, 0.3}, 3, 3, 3);
    // Irregular inside.
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      if ((mesh.nodes[n].array() > 0.01).all() && (mesh.nodes[n].array() < 0.29).all())
        mesh.nodes[n] += 0.02 * Vector3(std::sin(7.0 * double(n)), std::cos(5.0 * double(n)),
                                        std::sin(3.0 * double(n)));
    if (order == 2) mesh = with_mid_nodes(mesh);
    std::vector<int> moved;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      if ((mesh.nodes[n].array() < 1e-9).any() || (mesh.nodes[n].array() > 0.3 - 1e-9).any())
        moved.push_back(static_cast<int>(n));
    // The whole stiffness once, and that of the inner nodes alone.
    const DofMap everything(mesh, {}, {}), inner(mesh, moved, {});
    ASSERT_GT(inner.blocks(), 0);
    const BlockMatrix whole = assemble(mesh, {steel}, everything, pool, silent);
    const BlockMatrix equations = assemble(mesh, {steel}, inner, pool, silent);
    Eigen::VectorXd prescribed = Eigen::VectorXd::Zero(whole.size());
    for (const int n : moved)
      prescribed.segment<3>(3 * everything.block_of(n)) =
          a * mesh.nodes[static_cast<std::size_t>(n)];
    const Eigen::VectorXd forces =
        whole.residual(Eigen::VectorXd::Zero(whole.size()), prescribed).col(0);
    Eigen::VectorXd load(3 * inner.blocks());
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      if (const int block = inner.block_of(static_cast<int>(n)); block >= 0)
        load.segment<3>(3 * block) =
            forces.segment<3>(3 * everything.block_of(static_cast<int>(n)));
    const Eigen::VectorXd u = Factorisation(equations, 0).solve(load).col(0);
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      const int block = inner.block_of(static_cast<int>(n));
      if (block < 0) continue;
      EXPECT_LT((u.segment<3>(3 * block) - a * mesh.nodes[n]).norm(), 1e-15) << order;
    }
  }
}

TEST(DofMap, RefusesANodeWithTwoMasters) {
  const TetMesh mesh = box_mesh({1, 1, 1}, 1, 1, 1);
  EXPECT_THROW(DofMap(mesh, {0, 1}, {{Vector3::Zero(), {1, 2}}}), std::invalid_argument);
  EXPECT_THROW(DofMap(mesh, {}, {{Vector3::Zero(), {1}}, {Vector3::Zero(), {1}}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::fea::assembly_test
