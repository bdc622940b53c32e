#include "kinetostat/fea/link/modes.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>

#include "kinetostat/fea/elasticity/element_mass.h"
#include "kinetostat/fea/interface/average_motion.h"
#include "kinetostat/fea/link/calculix_deck.h"
#include "kinetostat/fea/link/reduced_model.h"
#include "kinetostat/io/text_file.h"

#include "fea/calculix_modes.h"
#include "fea/shapes.h"
#include "support/program.h"

namespace kinetostat::fea::modes_test {
namespace {

const Material steel(210e9, 0.3, 7850);

LinkModes modes(const TetMesh& mesh, const std::vector<CoupledInterface>& interfaces,
                Support support, int count, int threads = 1) {
  common::Progress silent;
  return link_modes(mesh, {steel}, interfaces, support, count, {.threads = threads}, silent);
}

// A bent block, so that nothing is symmetric.
TetMesh bent_block(int order = 2) {
  TetMesh mesh = box_mesh({0.1, 0.03, 0.02}, 10, 3, 2);
  for (Vector3& p : mesh.nodes) p += Vector3(0.1 * p.z(), 3 * p.x() * p.x(), 0.2 * p.x());
  return order == 2 ? with_mid_nodes(mesh) : mesh;
}

// First interface held as in the static deck, or not at all.
std::vector<double> by_calculix(const TetMesh& mesh, const std::vector<CoupledInterface>& ends,
                                bool is_held, std::size_t count) {
  std::string deck = calculix_deck("link", mesh, {steel}, ends);
  if (!is_held) {
    const std::string held = "*BOUNDARY\nINTERFACE0, 1, 3, 0.\n";
    deck.erase(deck.find(held), held.size());
  }
  return frequencies_by_calculix(deck, "", 7850, count);
}

// CalculiX integrates the mass of these elements at the four points of the stiffness, which takes
// some of it from short waves; here it is exact.
void expect_frequencies(const LinkModes& ours, const std::vector<double>& other) {
  ASSERT_EQ(ours.shapes.size(), other.size());
  for (std::size_t k = 0; k < other.size(); ++k) {
    EXPECT_NEAR(ours.frequency(k), other[k], 1e-3 * other[k]) << k;
    EXPECT_LT(ours.frequency(k), (1 + 1e-6) * other[k]) << k;
  }
}

class CalculiXModes : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(test::is_installed("ccx")); }
};

TEST_F(CalculiXModes, AreOursWhereTheFirstInterfaceIsHeld) {
  const TetMesh mesh = bent_block();
  for (const Coupling held : {Coupling::rigid, Coupling::distributing})
    for (const Coupling loaded : {Coupling::rigid, Coupling::distributing}) {
      const auto ends = coupled_ends(mesh, held, loaded);
      expect_frequencies(modes(mesh, ends, Support::first_interface, 6),
                         by_calculix(mesh, ends, true, 6));
    }
}

TEST_F(CalculiXModes, AreOursWhereNothingIsHeld) {
  const TetMesh mesh = bent_block();
  const auto ends = coupled_ends(mesh, Coupling::distributing, Coupling::rigid);
  // The deck of a rigid end holds it by a line that is taken out, and then nothing couples it.
  const auto held = coupled_ends(mesh, Coupling::rigid, Coupling::rigid);
  std::vector<double> other = by_calculix(mesh, held, false, 12);
  other.erase(other.begin(), other.begin() + 6);
  expect_frequencies(modes(mesh, ends, Support::none, 6), other);
}

// A rigid mass on six springs, whose frequencies follow from a 6x6 of each. Behind the layer of an
// interface that is not held nothing has mass.
TEST(LayeredModes, AreThoseOfARigidMassWhereTheBlockIsStiff) {
  const Vector3 size(0.1, 0.02, 0.012);
  const TetMesh mesh = with_mid_nodes(box_mesh(size, 5, 2, 2));
  const std::vector<Material> stiff{Material(2.1e14, 0, 7850)};
  auto ends = coupled_ends(mesh, Coupling::elastic, Coupling::elastic);
  const ElasticLayer layer{.normal = 1e10, .tangential = 4e9};
  ends[0].layer = ends[1].layer = layer;
  const double area = size.y() * size.z();
  const double about_y = area * size.z() * size.z() / 12, about_z = area * size.y() * size.y() / 12;
  Vector6 springs;
  springs << layer.normal * area, layer.tangential * area, layer.tangential * area,
      layer.tangential * (about_y + about_z), layer.normal * about_y, layer.normal * about_z;
  const RigidMass block = *rigid_mass(mesh, stiff);
  const auto motion = spatial::rigid_motion(Vector3(block.center - ends[0].point));
  Matrix6 mass = block.mass * motion.transpose() * motion;
  mass.bottomRightCorner<3, 3>() += block.inertia;
  const Eigen::VectorXd exact = natural_frequencies_squared(springs.asDiagonal(), mass);
  common::Progress silent;
  const LinkModes found = link_modes(mesh, stiff, ends, Support::first_interface, 6, {}, silent);
  for (Eigen::Index k = 0; k < 6; ++k)
    EXPECT_NEAR(found.omega_squared[k], exact[k], 1e-3 * exact[k]) << k;
}

// A bar of 100 mm, its cross-sections moved, turned and scaled as the shape says; `along` from 0
// to 1.
struct Shape {
  std::string name;
  std::function<Vector3(const Vector3&, double)> place;
};

class CalculiXShapes : public testing::TestWithParam<Shape> {};

TEST_P(CalculiXShapes, HaveTheSameModesOnTheSameMesh) {
  ASSERT_TRUE(test::is_installed("ccx"));
  constexpr double length = 0.1;
  TetMesh mesh = box_mesh({length, 0.03, 0.02}, 10, 3, 2);
  for (Vector3& p : mesh.nodes)
    p = GetParam().place(p - Vector3(0, 0.015, 0.01), p.x() / length);  // about the axis
  mesh = with_mid_nodes(mesh);
  const auto ends = coupled_ends(mesh, Coupling::rigid, Coupling::distributing);
  expect_frequencies(modes(mesh, ends, Support::first_interface, 8),
                     by_calculix(mesh, ends, true, 8));
}

// y and z scaled.
Vector3 scaled(const Vector3& p, double by) { return {p.x(), by * p.y(), by * p.z()}; }
Vector3 turned(const Vector3& p, double angle) {
  return {p.x(), std::cos(angle) * p.y() - std::sin(angle) * p.z(),
          std::sin(angle) * p.y() + std::cos(angle) * p.z()};
}

INSTANTIATE_TEST_SUITE_P(
    Eight, CalculiXShapes,
    testing::Values(
        Shape{"Straight", [](const Vector3& p, double) { return p; }},
        Shape{"Tapered", [](const Vector3& p, double s) { return scaled(p, 1 - 0.6 * s); }},
        Shape{"Twisted", [](const Vector3& p, double s) { return turned(p, 1.2 * s); }},
        Shape{"Bowed",
              [](const Vector3& p, double s) {
                return Vector3(p + Vector3(0, 0, 0.02 * std::sin(std::numbers::pi * s)));
              }},
        Shape{"SBent",
              [](const Vector3& p, double s) {
                return Vector3(p + Vector3(0, 0.03 * s * s * (3 - 2 * s), 0));
              }},
        Shape{"Waisted",
              [](const Vector3& p, double s) {
                return scaled(p, 1 - 0.5 * std::sin(std::numbers::pi * s));
              }},
        Shape{"Bulged",
              [](const Vector3& p, double s) {
                return scaled(p, 1 + 0.5 * std::sin(std::numbers::pi * s));
              }},
        Shape{"Arched",  // a sixth of a circle
              [](const Vector3& p, double s) {
                const double angle = s * std::numbers::pi / 3, radius = 0.3 / std::numbers::pi;
                return Vector3((radius + p.z()) * std::sin(angle), p.y(),
                               (radius + p.z()) * std::cos(angle));
              }}),
    [](const auto& shape) { return shape.param.name; });

// Roots of cos x cosh x = -1 and = 1: cantilever and free beam.
constexpr double cantilever[] = {1.8751040687119611, 4.6940911329741746};
constexpr double free_beam[] = {4.7300407448627040, 7.8532046240958376};

// Euler and Bernoulli's frequency [Hz] for a beam of this depth in the direction of bending.
double slender(double root, double length, double depth) {
  return root * root / (2 * std::numbers::pi * length * length) *
         std::sqrt(210e9 / 7850 * depth * depth / 12);
}

// The first correction for shear and rotary inertia (Timoshenko): the frequency falls by a share of
// (k r / L)^2 of the order of one, with r the radius of gyration.
double slenderness(double root, double length, double depth) {
  return root * root * depth * depth / (12 * length * length);
}

TEST(LinkModes, OfASlenderCantileverAreEulersAndBernoullis) {
  const double length = 2, width = 0.03, height = 0.02;
  const TetMesh mesh = with_mid_nodes(box_mesh({length, width, height}, 80, 2, 2));
  const LinkModes found = modes(mesh, coupled_ends(mesh, Coupling::rigid, Coupling::distributing),
                                Support::first_interface, 4);
  const double expected[] = {
      slender(cantilever[0], length, height), slender(cantilever[0], length, width),
      slender(cantilever[1], length, height), slender(cantilever[1], length, width)};
  const double small[] = {
      slenderness(cantilever[0], length, height), slenderness(cantilever[0], length, width),
      slenderness(cantilever[1], length, height), slenderness(cantilever[1], length, width)};
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(found.frequency(k), expected[k], (0.003 + 4 * small[k]) * expected[k]) << k;
}

// Timoshenko's beam, free at both ends, by its characteristic equation: symmetric and antisymmetric
// modes of w(x) = A cos(a x) + B cosh(b x) about the middle. Cowper's shear coefficient.
double timoshenko_free(int mode, double length, double depth, double near) {
  const double e = 210e9, rho = 7850, g = e / 2.6, kappa = 10 * 1.3 / (12 + 11 * 0.3);
  const double r2 = depth * depth / 12, sigma = e / (kappa * g), h = length / 2;
  const auto mismatch = [&](double f) {
    const double omega = 2 * std::numbers::pi * f, c = rho * omega * omega / e;
    const double half = c * (1 + sigma) / 2,
                 root = std::sqrt(c * c * (1 - sigma) * (1 - sigma) / 4 + c / r2);
    const double a = std::sqrt(half + root), b = std::sqrt(root - half);
    // The section turns by psi with psi' = w'' + q w; the moment goes with psi', the shear with
    // w' - psi.
    const double q = c * sigma;
    const double pa = (a * a - q) / a, pb = (b * b + q) / b;
    if (mode % 2 == 1)  // symmetric: cos and cosh
      return -pa * a * std::cos(a * h) * ((b - pb) * std::sinh(b * h)) -
             pb * b * std::cosh(b * h) * (-(a - pa) * std::sin(a * h));
    return -pa * a * std::sin(a * h) * ((b - pb) * std::cosh(b * h)) -
           pb * b * std::sinh(b * h) * ((a - pa) * std::cos(a * h));
  };
  double low = 0.8 * near, high = 1.02 * near;
  EXPECT_LT(mismatch(low) * mismatch(high), 0);
  for (int k = 0; k < 80; ++k) {
    const double middle = (low + high) / 2;
    (mismatch(low) * mismatch(middle) <= 0 ? high : low) = middle;
  }
  return low;
}

TEST(LinkModes, OfAFreeBeamAreTimoshenkos) {
  const double length = 0.5, side = 0.04;
  const TetMesh mesh = with_mid_nodes(box_mesh({length, side, side}, 30, 2, 2));
  const LinkModes found = modes(
      mesh, coupled_ends(mesh, Coupling::distributing, Coupling::distributing), Support::none, 4);
  for (const int mode : {1, 2}) {
    const double thin = slender(free_beam[mode - 1], length, side);
    const double exact = timoshenko_free(mode, length, side, thin);
    EXPECT_LT(exact, 0.99 * thin);  // the correction is seen
    // In both directions of the square section.
    EXPECT_NEAR(found.frequency(2 * static_cast<std::size_t>(mode) - 2), exact, 0.002 * exact);
    EXPECT_NEAR(found.frequency(2 * static_cast<std::size_t>(mode) - 1), exact, 0.002 * exact);
  }
}

TEST(LinkModes, AreOrthogonalAndHaveAModalMassOfOne) {
  const TetMesh mesh = bent_block();
  for (const Support support : {Support::first_interface, Support::none, Support::all_interfaces}) {
    const LinkModes found =
        modes(mesh, coupled_ends(mesh, Coupling::distributing, Coupling::rigid), support, 5);
    for (std::size_t i = 0; i < 5; ++i) {
      const Eigen::Matrix3Xd forces = inertial_forces(mesh, {steel}, found.shapes[i]);
      for (std::size_t j = 0; j < 5; ++j)
        EXPECT_NEAR(forces.cwiseProduct(found.shapes[j]).sum(), i == j ? 1 : 0, 1e-8);
      EXPECT_GT(found.shapes[i].maxCoeff(), -found.shapes[i].minCoeff());
    }
  }
}

TEST(LinkModes, OfAFreeLinkHaveNoMomentum) {
  const TetMesh mesh = bent_block();
  const LinkModes found = modes(mesh, coupled_ends(mesh), Support::none, 4);
  for (const Eigen::Matrix3Xd& shape : found.shapes) {
    const Eigen::Matrix3Xd momenta = inertial_forces(mesh, {steel}, shape);
    Vector3 turning = Vector3::Zero();
    for (Eigen::Index n = 0; n < momenta.cols(); ++n)
      turning += mesh.nodes[static_cast<std::size_t>(n)].cross(momenta.col(n));
    const double scale = momenta.colwise().norm().sum();
    EXPECT_LT(momenta.rowwise().sum().norm(), 1e-9 * scale);
    EXPECT_LT(turning.norm(), 1e-9 * scale);
  }
}

TEST(LinkModes, LeaveHeldInterfacesWithoutMeanMotion) {
  const TetMesh mesh = bent_block();
  const auto ends = coupled_ends(mesh, Coupling::distributing, Coupling::distributing);
  const LinkModes found = modes(mesh, ends, Support::all_interfaces, 4);
  for (const Eigen::Matrix3Xd& shape : found.shapes)
    for (const CoupledInterface& end : ends)
      EXPECT_LT(AverageMotion(mesh, end.geometry, end.point).of(shape).head<3>().norm(),
                1e-8 * shape.cwiseAbs().maxCoeff());
}

// A support more raises every frequency (Rayleigh): free in the mean below held in the mean below
// held rigidly.
TEST(LinkModes, RiseWithEverySupport) {
  const TetMesh mesh = bent_block();
  const auto soft = coupled_ends(mesh, Coupling::distributing, Coupling::distributing),
             stiff = coupled_ends(mesh);
  const LinkModes clamped = modes(mesh, soft, Support::first_interface, 6),
                  rigid = modes(mesh, stiff, Support::first_interface, 6),
                  held = modes(mesh, soft, Support::all_interfaces, 6),
                  held_rigidly = modes(mesh, stiff, Support::all_interfaces, 6);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_LT(clamped.frequency(k), rigid.frequency(k));
    EXPECT_LT(clamped.frequency(k), held.frequency(k));
    EXPECT_LT(rigid.frequency(k), held_rigidly.frequency(k));
    EXPECT_LT(held.frequency(k), held_rigidly.frequency(k));
  }
}

TEST(LinkModes, AreTheSameOnAnyNumberOfThreads) {
  const TetMesh mesh = bent_block();
  const auto ends = coupled_ends(mesh);
  const LinkModes one = modes(mesh, ends, Support::first_interface, 5, 1),
                  three = modes(mesh, ends, Support::first_interface, 5, 3);
  EXPECT_EQ(one.omega_squared, three.omega_squared);
  EXPECT_EQ(one.shapes[4], three.shapes[4]);
}

TEST(LinkModes, NeedADensity) {
  const TetMesh mesh = bent_block(1);
  common::Progress silent;
  EXPECT_THROW(link_modes(mesh, {Material(210e9, 0.3)}, coupled_ends(mesh),
                          Support::first_interface, 2, {}, silent),
               std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::fea::modes_test
