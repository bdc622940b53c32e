#include "kinetostat/fea/linear_algebra/factorisation.h"

#include <gtest/gtest.h>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/linear_algebra/blas.h"

#include "fea/shapes.h"

namespace kinetostat::fea::factorisation_test {
namespace {

const Material steel(210e9, 0.3);

TEST(Factorisation, SolvesToTheResidualOfRounding) {
  common::Progress silent;
  common::ThreadPool pool(2);
  const TetMesh mesh = with_mid_nodes(box_mesh({0.4, 0.1, 0.1}, 8, 2, 2));
  const DofMap unknowns(mesh, interface_on(mesh, 1).nodes,
                        {{Vector3(0.4, 0.05, 0.05), interface_on(mesh, 2).nodes}});
  const BlockMatrix equations = assemble(mesh, {steel}, unknowns, pool, silent);
  const Factorisation factorisation(equations, 1);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Ones(equations.size(), 2);
  const Eigen::MatrixXd x = factorisation.solve(b);
  EXPECT_LT(equations.residual(b, x).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_GT(factorisation.stats().entries, 0);
}

TEST(Factorisation, SaysThatAnUnsupportedBodyCanMove) {
  common::Progress silent;
  common::ThreadPool pool(2);
  const TetMesh mesh = with_mid_nodes(box_mesh({0.4, 0.1, 0.1}, 8, 2, 2));
  const DofMap unknowns(mesh, {}, {{Vector3(0.4, 0.05, 0.05), interface_on(mesh, 2).nodes}});
  const BlockMatrix equations = assemble(mesh, {steel}, unknowns, pool, silent);
  EXPECT_THROW(Factorisation(equations, 1), SingularStiffness);
}

TEST(Factorisation, SaysThatABodyOnOneHingeCanMove) {
  common::Progress silent;
  common::ThreadPool pool(2);
  const TetMesh mesh = with_mid_nodes(box_mesh({0.4, 0.1, 0.1}, 8, 2, 2));
  // All nodes on one straight edge: the body turns about it.
  std::vector<int> edge;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (mesh.nodes[n].y() == 0 && mesh.nodes[n].z() == 0) edge.push_back(static_cast<int>(n));
  const DofMap unknowns(mesh, edge, {});
  const BlockMatrix equations = assemble(mesh, {steel}, unknowns, pool, silent);
  EXPECT_THROW(Factorisation(equations, 0), SingularStiffness);
}

TEST(Blas, IsNamedAndSetBack) {
  const BlasInfo before = blas_info();
  EXPECT_FALSE(before.name.empty());
  {
    const OneBlasThread one;
    if (before.threads > 0) {
      EXPECT_EQ(blas_info().threads, 1);
    }
  }
  EXPECT_EQ(blas_info().threads, before.threads);
}

}  // namespace
}  // namespace kinetostat::fea::factorisation_test
