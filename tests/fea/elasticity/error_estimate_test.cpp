#include "kinetostat/fea/elasticity/error_estimate.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "fea/reference_bar.h"

namespace kinetostat::fea::error_estimate_test {
namespace {

common::ThreadPool alone(1);

// Nodal values of a displacement that is given everywhere.
template <class Displacement>
Eigen::Matrix3Xd sampled(const TetMesh& mesh, Displacement u) {
  Eigen::Matrix3Xd field(3, static_cast<Eigen::Index>(mesh.nodes.size()));
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    field.col(static_cast<Eigen::Index>(n)) = u(mesh.nodes[n]);
  return field;
}

TEST(StressRecovery, StressesOfAGivenDisplacementFollowHookesLaw) {
  const TetMesh mesh = with_mid_nodes(box_mesh({3, 2, 1}, 3, 2, 1));
  const Material material(200, 0.25);  // lambda = mu = 80
  const Eigen::Matrix3Xd u =
      sampled(mesh, [](const Vector3& p) { return Vector3(p.x() * p.x(), p.x() * p.y(), 0); });
  const Stresses stresses = corner_stresses(mesh, {material}, {u}, alone);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3 p = mesh.corners(e)[k];
      Vector6 expected;  // strains 2x, x, 0 and the shear angle xy = y
      expected << 80 * 3 * p.x() + 160 * 2 * p.x(), 80 * 3 * p.x() + 160 * p.x(), 80 * 3 * p.x(),
          80 * p.y(), 0, 0;
      EXPECT_LT((stresses.col(static_cast<Eigen::Index>(4 * e + k)) - expected).norm(), 1e-9);
    }
}

// The recovery must not invent an error where there is none: a stress in the space of the elements.
TEST(StressRecovery, LeavesTheStressesOfAQuadraticDisplacementAlone) {
  const TetMesh mesh = with_mid_nodes(box_mesh({3, 2, 1}, 4, 3, 2));
  const Material material(200, 0.25);
  const Eigen::Matrix3Xd u = sampled(mesh, [](const Vector3& p) {
    return Vector3(p.x() * p.y() + p.z(), p.z() * p.z() - p.x(), p.y() * p.x());
  });
  const ErrorEstimate error = estimate_error(mesh, {material}, {u}, alone);
  const Stresses stresses = corner_stresses(mesh, {material}, {u}, alone);
  EXPECT_LT(error.total(0, 0), 1e-12 * stresses.squaredNorm() / material.young());
}

// Uniform tension is held by elements with curved edges, too.
TEST(StressRecovery, FindsNoErrorInUniformTensionOfCurvedElements) {
  TetMesh mesh = with_mid_nodes(box_mesh({2, 1, 1}, 4, 2, 2));
  for (Vector3& p : mesh.nodes) p.y() += 0.05 * std::sin(3 * p.x()) * p.y();
  mesh.curved = true;
  for (BoundaryFace& face : mesh.boundary) face.tag = 1;  // all of them carry a load
  const Eigen::Matrix3Xd u =
      sampled(mesh, [](const Vector3& p) { return Vector3(p.x(), -0.25 * p.y(), -0.25 * p.z()); });
  const Stresses stresses = corner_stresses(mesh, {Material(200, 0.25)}, {u}, alone);
  const Vector6 tension{200, 0, 0, 0, 0, 0};
  EXPECT_LT((stresses.colwise() - tension).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(estimate_error(mesh, {Material(200, 0.25)}, {u}, alone).total(0, 0), 1e-12);
}

// The traction of a curved free surface vanishes along the normal of the surface, not of its
// facets.
TEST(StressRecovery, KnowsTheFreeSurfaceOfCurvedElements) {
  // Lame's stresses of a thick ring under pressure inside, r from 1 to 2: the outside is free.
  const auto ring = [](int n) {
    TetMesh mesh = with_mid_nodes(box_mesh({1, 1, 0.5}, 2 * n, 2 * n, n));
    for (Vector3& p : mesh.nodes) {
      const double r = 1 + p.x(), angle = p.y();
      p = {r * std::cos(angle), r * std::sin(angle), p.z()};
    }
    for (BoundaryFace& face : mesh.boundary) {
      const Vector3& a = mesh.nodes[static_cast<std::size_t>(face.nodes[0])];
      const Vector3& b = mesh.nodes[static_cast<std::size_t>(face.nodes[1])];
      const Vector3& c = mesh.nodes[static_cast<std::size_t>(face.nodes[2])];
      const auto outside = [](const Vector3& p) { return std::hypot(p.x(), p.y()) > 2 - 1e-9; };
      face.tag = outside(a) && outside(b) && outside(c) ? 0 : 1;
    }
    mesh.curved = true;
    return mesh;
  };
  // Plane strain, E = 1, nu = 0: u_r = (r + 4 / r) / 3 for a pressure of 1; no stress along z.
  const auto estimated = [&](int n) {
    const TetMesh mesh = ring(n);
    const Eigen::Matrix3Xd u = sampled(mesh, [](const Vector3& p) {
      const double r = std::hypot(p.x(), p.y()), stretch = (1 + 4 / (r * r)) / 3;
      return Vector3(stretch * p.x(), stretch * p.y(), 0);
    });
    return estimate_error(mesh, {Material(1, 0)}, {u}, alone).total(0, 0);
  };
  // Energy of the sector of 1 rad: half of what the pressure does, here without the half: 0.5 m
  // deep, radius 1, u_r(1) = 5/3.
  const double energy = 0.5 * 5.0 / 3;
  const double coarse = estimated(2), fine = estimated(4);
  EXPECT_LT(coarse, 0.01 * energy);
  EXPECT_LT(fine, coarse / 8);  // 16 for second order
}

// Pure bending of a prism: its stress is linear and its sides carry nothing, which the recovery
// asks for on the faces with tag 0.
TEST(StressRecovery, KeepsPureBendingWithFreeSides) {
  const ReferenceBar bar(0.01);
  const double nu = bar.steel.poisson();
  const Eigen::Matrix3Xd u = sampled(bar.mesh, [nu](const Vector3& p) {
    return Vector3(p.x() * p.z(), -nu * p.y() * p.z(),
                   -0.5 * (p.x() * p.x() + nu * (p.z() * p.z() - p.y() * p.y())));
  });
  const double energy = bar.steel.young() * ReferenceBar::length * ReferenceBar::width *
                        std::pow(ReferenceBar::height, 3) / 12;
  EXPECT_LT(estimate_error(bar.mesh, {bar.steel}, {u}, alone).total(0, 0), 1e-12 * energy);
}

// A jump of the modulus makes the stress jump, which is no error: a bar of two materials in
// tension.
TEST(StressRecovery, LetsStressesJumpBetweenMaterials) {
  TetMesh mesh = with_mid_nodes(box_mesh({2, 1, 1}, 4, 2, 2));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    double x = 0;
    for (const Vector3& p : mesh.corners(e)) x += p.x() / 4;
    mesh.materials.push_back(x < 1 ? 0 : 1);
  }
  const Eigen::Matrix3Xd u = sampled(mesh, [](const Vector3& p) {
    return Vector3(p.x() < 1 ? p.x() : 1 + (p.x() - 1) / 10, 0, 0);
  });
  const ErrorEstimate error = estimate_error(mesh, {Material(1, 0), Material(10, 0)}, {u}, alone);
  EXPECT_LT(error.total(0, 0), 1e-12);
}

class BarError : public testing::Test {
 protected:
  struct Result {
    Matrix6 compliance;
    ErrorEstimate error;
  };
  static Result solved(double size) {
    const ReferenceBar bar(size);
    common::Progress silent;
    std::vector<CoupledInterface> ends = coupled_ends(bar.mesh);
    ends[1].point = bar.tip;
    const LinkResponse response = respond(bar.mesh, {bar.steel}, ends, {}, silent);
    return {response.compliance(), estimate_error(bar.mesh, {bar.steel}, response.fields, alone)};
  }
};

TEST_F(BarError, IsTheSumOverTheElementsAndPositive) {
  const Result bar = solved(0.012);
  Eigen::Index entry = 0;
  for (Eigen::Index j = 0; j < 6; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      const double sum = bar.error.by_element.row(entry++).sum();
      EXPECT_NEAR(sum, bar.error.total(i, j), 1e-12 * bar.error.total.norm());
      EXPECT_EQ(bar.error.total(i, j), bar.error.total(j, i));
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(bar.error.total);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
}

// The estimate beside the change of the compliance when the mesh becomes much finer.
TEST_F(BarError, IsCloseToTheTrueError) {
  const Result coarse = solved(0.010), fine = solved(0.004);
  for (int i = 0; i < 6; ++i) {
    const double exact = fine.compliance(i, i) + fine.error.total(i, i);
    const double ratio = coarse.error.total(i, i) / (exact - coarse.compliance(i, i));
    EXPECT_GT(ratio, 0.7) << i;
    EXPECT_LT(ratio, 1.4) << i;
  }
}

}  // namespace
}  // namespace kinetostat::fea::error_estimate_test
