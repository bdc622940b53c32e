#include "kinetostat/fea/elasticity/element_mass.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "kinetostat/fea/elasticity/assembly.h"

#include "fea/shapes.h"

namespace kinetostat::fea::element_mass_test {
namespace {

const Material steel(210e9, 0.3, 7850);

TetMesh skewed_element(int order) {
  TetMesh mesh;
  mesh.nodes = {{0.1, 0.2, 0}, {1.3, 0.1, 0.2}, {0.3, 0.9, -0.1}, {0.4, 0.5, 1.1}};
  mesh.connectivity = {0, 1, 2, 3};
  return order == 2 ? with_mid_nodes(mesh) : mesh;
}

Vector3 node(const TetMesh& mesh, Eigen::Index number) {
  return mesh.nodes[static_cast<std::size_t>(mesh.connectivity[static_cast<std::size_t>(number)])];
}

// Straight edges, then the middles moved.
TetMesh curved_element(double by) {
  TetMesh mesh = skewed_element(2);
  mesh.curved = true;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> move(-by, by);
  for (std::size_t n = 4; n < 10; ++n)
    mesh.nodes[n] += Vector3(move(random), move(random), move(random));
  return mesh;
}

TEST(ElementMass, AddsUpToTheVolume) {
  for (const TetMesh& mesh : {skewed_element(1), skewed_element(2), curved_element(0.05)}) {
    const double exact = mass_properties(mesh).volume;
    EXPECT_NEAR(shape_products(mesh, 0).sum(), exact, 1e-14 * exact);
  }
}

// The table of straight edges, and the quadrature of curved ones.
TEST(ElementMass, OfStraightEdgesIsAlsoThatOfTheQuadrature) {
  const Eigen::MatrixXd straight = shape_products(skewed_element(2), 0),
                        curved = shape_products(curved_element(0), 0);
  EXPECT_LT((straight - curved).cwiseAbs().maxCoeff(), 1e-15 * straight.cwiseAbs().sum());
}

// The places are sums of the shape functions, so that the products give the second moment.
TEST(ElementMass, CarriesTheSecondMomentOfAnElement) {
  for (const TetMesh& mesh : {skewed_element(1), skewed_element(2)}) {
    const MassProperties exact = mass_properties(mesh);
    Eigen::Matrix3Xd arms(3, static_cast<Eigen::Index>(mesh.nodes.size()));
    for (Eigen::Index n = 0; n < arms.cols(); ++n) arms.col(n) = node(mesh, n) - exact.centroid;
    const Matrix3 second = arms * shape_products(mesh, 0) * arms.transpose();
    EXPECT_LT((second - exact.second_moment).norm(), 1e-13 * exact.second_moment.norm());
  }
}

using Polynomial = std::vector<double>;  // of one coordinate, ascending powers

// The integral of a(x) b(y) c(z) over the unit tetrahedron: x^i y^j z^k has i! j! k! / (i+j+k+3)!.
double integral(const Polynomial& a, const Polynomial& b, const Polynomial& c) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      for (std::size_t k = 0; k < c.size(); ++k)
        sum += a[i] * b[j] * c[k] * std::tgamma(i + 1.0) * std::tgamma(j + 1.0) *
               std::tgamma(k + 1.0) / std::tgamma(static_cast<double>(i + j + k) + 4.0);
  return sum;
}

// The unit tetrahedron with each coordinate x taken to x + 0.1 x^2: second moments are integrals of
// seventh degree.
TEST(ElementMass, OfACurvedElementIsExact) {
  TetMesh mesh;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.connectivity = {0, 1, 2, 3};
  mesh = with_mid_nodes(mesh);
  mesh.curved = true;
  for (Vector3& p : mesh.nodes) p += 0.1 * p.cwiseProduct(p);
  Eigen::Matrix3Xd places(3, 10);
  for (Eigen::Index n = 0; n < 10; ++n) places.col(n) = node(mesh, n);
  const Matrix3 second = places * shape_products(mesh, 0) * places.transpose();
  const Polynomial length{1, 0.2},        // d(x + 0.1 x^2)/dx
      first{0, 1, 0.3, 0.02},             // times x + 0.1 x^2
      square{0, 0, 1, 0.4, 0.05, 0.002};  // times its square
  EXPECT_NEAR(second(0, 0), integral(square, length, length), 1e-15);
  EXPECT_NEAR(second(0, 1), integral(first, first, length), 1e-15);
}

// A power of a barycentric coordinate that needs the full degree: the integral of L0^4 over the
// unit tetrahedron is 4! / 7!, and L0^2 is a sum of shape functions.
TEST(ElementMass, IsExactToTheFourthDegree) {
  const TetMesh mesh = skewed_element(2);
  Eigen::VectorXd square = Eigen::VectorXd::Zero(10);  // of L0, at the nodes
  square[0] = 1;
  for (Eigen::Index e = 0; e < 6; ++e)
    if (tet_edges[static_cast<std::size_t>(e)][0] == 0 ||
        tet_edges[static_cast<std::size_t>(e)][1] == 0)
      square[4 + e] = 0.25;
  const double exact = 6 * volume(mesh.corners(0)) * 24 / 5040;
  EXPECT_NEAR(square.dot(shape_products(mesh, 0) * square), exact, 1e-14);
}

// Through the motions of held nodes and of a body, on any number of threads.
TEST(AssembledMass, IsThatOfAllNodesSeenThroughTheUnknowns) {
  common::Progress silent;
  const TetMesh mesh = with_mid_nodes(box_mesh({0.3, 0.1, 0.1}, 3, 1, 1));
  const DofMap unknowns(mesh, interface_on(mesh, 1).nodes,
                        {{Vector3(0.35, 0.02, 0.05), interface_on(mesh, 2).nodes}});
  common::ThreadPool one(1), three(3);
  const BlockMatrix mass = assemble_mass(mesh, {steel}, unknowns, one, silent);
  EXPECT_EQ(mass.value, assemble_mass(mesh, {steel}, unknowns, three, silent).value);
  const Eigen::VectorXd x = Eigen::VectorXd::Random(mass.size()),
                        y = Eigen::VectorXd::Random(mass.size());
  const double product = -y.dot(mass.residual(Eigen::VectorXd::Zero(mass.size()), x).col(0));
  const double expected = inertial_forces(mesh, {steel}, unknowns.displacements(mesh, x))
                              .cwiseProduct(unknowns.displacements(mesh, y))
                              .sum();
  EXPECT_NEAR(product, expected, 1e-12 * std::abs(expected));
}

}  // namespace
}  // namespace kinetostat::fea::element_mass_test
