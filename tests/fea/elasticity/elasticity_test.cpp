#include "kinetostat/fea/elasticity/elasticity.h"

#include <limits>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "fea/shapes.h"

namespace kinetostat::fea::elasticity_test {
namespace {

const std::array<Vector3, 4> skewed{Vector3(0.1, 0.2, 0), Vector3(1.3, 0.1, 0.2),
                                    Vector3(0.3, 0.9, -0.1), Vector3(0.4, 0.5, 1.1)};
const Material steel(210e9, 0.3);

Eigen::Matrix3Xd nodes_of(const std::array<Vector3, 4>& corners, int count) {
  Eigen::Matrix3Xd nodes(3, count);
  for (int k = 0; k < 4; ++k) nodes.col(k) = corners[static_cast<std::size_t>(k)];
  for (int e = 0; e < count - 4; ++e) {
    const auto [a, b] = tet_edges[static_cast<std::size_t>(e)];
    nodes.col(4 + e) = 0.5 * (nodes.col(a) + nodes.col(b));
  }
  return nodes;
}

template <class Stiffness>
void expect_six_rigid_motions_and_no_more(const Stiffness& k) {
  const Eigen::SelfAdjointEigenSolver<Stiffness> eigen(k);
  const double largest = eigen.eigenvalues().maxCoeff();
  EXPECT_LT(eigen.eigenvalues().head(6).cwiseAbs().maxCoeff(), 1e-13 * largest);
  EXPECT_GT(eigen.eigenvalues()(6), 1e-4 * largest);
}

TEST(ElementStiffness, IsSymmetric) {
  const auto k = stiffness_tet10(skewed, steel);
  EXPECT_LT((k - k.transpose()).cwiseAbs().maxCoeff(), 1e-15 * k.cwiseAbs().maxCoeff());
}

TEST(ElementStiffness, HasSixRigidMotionsAndNoOtherFreeOne) {
  expect_six_rigid_motions_and_no_more(stiffness_tet4(skewed, steel));
  expect_six_rigid_motions_and_no_more(stiffness_tet10(skewed, steel));
}

// Under u = A x the energy is V/2 (lambda tr(e)^2 + 2 mu e:e), with the strain e from A.
template <int Nodes>
double energy_of_linear_field(const ElementStiffness<Nodes>& k, const Matrix3& a) {
  const Eigen::Matrix3Xd u = a * nodes_of(skewed, Nodes);
  const Eigen::VectorXd flat = u.reshaped();
  return 0.5 * flat.dot(k * flat);
}

TEST(ElementStiffness, StoresTheEnergyOfALinearFieldExactly) {
  Matrix3 a;
  a << 0.3, -0.2, 0.7, 0.1, 0.5, -0.4, -0.6, 0.2, 0.9;
  const Matrix3 strain = 0.5 * (a + a.transpose());
  const double exact =
      volume(skewed) / 2 *
      (steel.lambda() * strain.trace() * strain.trace() + 2 * steel.mu() * strain.squaredNorm());
  EXPECT_NEAR(energy_of_linear_field<4>(stiffness_tet4(skewed, steel), a), exact, 1e-13 * exact);
  EXPECT_NEAR(energy_of_linear_field<10>(stiffness_tet10(skewed, steel), a), exact, 1e-13 * exact);
}

// u = (x^2, 0, 0): strain xx = 2x only, energy (lambda + 2 mu)/2 times the integral of 4 x^2.
TEST(ElementStiffness, StoresTheEnergyOfAQuadraticFieldExactly) {
  const Eigen::Matrix3Xd nodes = nodes_of(skewed, 10);
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, 10);
  u.row(0) = nodes.row(0).array().square();
  const Eigen::VectorXd flat = u.reshaped();
  double sum = 0, squares = 0;
  for (const Vector3& p : skewed) {
    sum += p.x();
    squares += p.x() * p.x();
  }
  const double integral = volume(skewed) / 20 * (squares + sum * sum);
  const double exact = 0.5 * (steel.lambda() + 2 * steel.mu()) * 4 * integral;
  EXPECT_NEAR(0.5 * flat.dot(stiffness_tet10(skewed, steel) * flat), exact, 1e-13 * exact);
}

TEST(Material, RefusesWhatNoMaterialIs) {
  EXPECT_THROW(Material(0, 0.3), std::invalid_argument);
  EXPECT_THROW(Material(-1, 0.3), std::invalid_argument);
  EXPECT_THROW(Material(1, 0.5), std::invalid_argument);
  EXPECT_THROW(Material(1, -1), std::invalid_argument);
  EXPECT_THROW(Material(1, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(Material(1, 0.3, 0.0), std::invalid_argument);
  EXPECT_NO_THROW(Material(1, -0.9));
}

}  // namespace
}  // namespace kinetostat::fea::elasticity_test
