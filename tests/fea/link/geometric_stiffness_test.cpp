// A slender bar under load against the beam column, and properties that hold for any link.
#include "kinetostat/fea/link/geometric_stiffness.h"

#include <cstdlib>
#include <sstream>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "kinetostat/fea/elasticity/prestress.h"
#include "kinetostat/fea/link/calculix_deck.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"

#include "fea/shapes.h"
#include "support/program.h"

namespace kinetostat::fea::geometric_stiffness_test {
namespace {

const Material material(210e9, 0.3);

// A slender bar along x, held at x = 0.
struct Bar {
  static constexpr double length = 1, width = 0.02, height = 0.016;           // along x, y, z [m]
  static constexpr double inertia_y = width * height * height * height / 12;  // bends in z [m^4]
  static constexpr double inertia_z = height * width * width * width / 12;    // bends in y [m^4]
  static constexpr double young = 210e9;
  TetMesh mesh = with_mid_nodes(box_mesh({length, width, height}, 64, 2, 2));
  std::vector<CoupledInterface> ends = coupled_ends(mesh);
  LinkResponse response;

  explicit Bar(const Vector3& offset = Vector3::Zero()) {
    ends[1].point += offset;
    common::Progress silent;
    response = respond(mesh, {material}, ends, {}, silent);
  }
  GeometricStiffness under(const Vector6& preload) const {
    common::Progress silent;
    return geometric_stiffness(mesh, {material}, ends, response, preload, silent);
  }
  static double euler() { return M_PI * M_PI * young * inertia_y / (4 * length * length); }
};

Vector6 push(double force) { return -force * Vector6::Unit(0); }

// Stiffness of a clamped beam column's moved end in v and its slope, under the axial force p
// (compression positive): Timoshenko and Gere, Theory of Elastic Stability, 1.11.
Eigen::Matrix2d beam_column(double ei, double length, double p) {
  const double k = std::sqrt(std::abs(p) / ei), u = k * length;
  Eigen::Matrix2d m;
  if (p > 0)
    m << k * k * std::sin(u), -k * (1 - std::cos(u)),  //
        -k * (1 - std::cos(u)), std::sin(u) - u * std::cos(u);
  else
    m << k * k * std::sinh(u), -k * (std::cosh(u) - 1),  //
        -k * (std::cosh(u) - 1), u * std::cosh(u) - std::sinh(u);
  const double d =
      p > 0 ? 2 - 2 * std::cos(u) - u * std::sin(u) : 2 - 2 * std::cosh(u) + u * std::sinh(u);
  return ei * k / d * m;
}

TEST(BeamColumn, FormulaTendsToTheBeamWithoutAxialForce) {
  for (const double p : {1e-3, -1e-3}) {
    const Eigen::Matrix2d m = beam_column(2.0, 3.0, p);
    EXPECT_NEAR(m(0, 0), 12 * 2.0 / 27, 1e-3);
    EXPECT_NEAR(m(0, 1), -6 * 2.0 / 9, 1e-3);
    EXPECT_NEAR(m(1, 1), 4 * 2.0 / 3, 1e-3);
  }
}

TEST(GeometricStiffness, SlenderBarIsABeamColumnInTensionAndCompression) {
  const Bar bar;
  const Matrix6 unloaded = bar.under(Vector6::Zero()).stiffness;
  for (const double share : {-3.0, -0.5, 0.5, 2.0, 8.0}) {  // of Euler's load of the cantilever
    const double p = share * Bar::euler();
    const Matrix6 k = bar.under(push(p)).stiffness;
    const Eigen::Matrix2d in_y = beam_column(Bar::young * Bar::inertia_z, Bar::length, p),
                          in_z = beam_column(Bar::young * Bar::inertia_y, Bar::length, p);
    // Bending in y turns about z with the slope, in z about y against it. Where the load has taken
    // nearly all of an entry, one percent of what it was.
    const auto expect = [&](int i, int j, double expected) {
      EXPECT_NEAR(k(i, j), expected, 0.01 * std::max(std::abs(expected), std::abs(unloaded(i, j))))
          << i << j << " at " << share;
    };
    expect(1, 1, in_y(0, 0));
    expect(1, 5, in_y(0, 1));
    expect(5, 5, in_y(1, 1));
    expect(2, 2, in_z(0, 0));
    expect(2, 4, -in_z(0, 1));
    expect(4, 4, in_z(1, 1));
    EXPECT_NEAR(k(0, 0), unloaded(0, 0), 1e-3 * unloaded(0, 0)) << share;
  }
}

TEST(GeometricStiffness, BucklingLoadIsEulers) {
  const GeometricStiffness result = Bar().under(push(1000));
  EXPECT_NEAR(1000 * result.buckling_free, Bar::euler(), 0.01 * Bar::euler());
  EXPECT_NEAR(1000 * result.buckling_held, 16 * Bar::euler(), 0.01 * 16 * Bar::euler());
  const GeometricStiffness pulled = Bar().under(push(-1000));
  EXPECT_GT(pulled.buckling_free, 50 * result.buckling_free);
}

// At the free buckling load the stiffness of the moved end is singular; below it is not.
TEST(GeometricStiffness, IsSingularWhereTheLinkBuckles) {
  const Bar bar;
  const double factor = bar.under(push(1000)).buckling_free;
  const auto least = [&](double load) {
    const Matrix6 k = bar.under(push(load)).stiffness;
    const Vector6 d = k.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
    const Matrix6 scaled = d.asDiagonal() * k * d.asDiagonal();
    return Eigen::SelfAdjointEigenSolver<Matrix6>(scaled).eigenvalues()[0];
  };
  EXPECT_GT(least(0.99 * 1000 * factor), 1e-5);
  EXPECT_LT(least(1.01 * 1000 * factor), -1e-5);
  EXPECT_NEAR(least(1000 * factor), 0, 1e-6);
}

// The same tetrahedra in CalculiX's own buckling analysis, loaded where nothing is symmetric.
TEST(GeometricStiffness, BucklingFactorIsCalculiXs) {
  ASSERT_TRUE(test::is_installed("ccx"));
  Bar bar;
  for (Vector3& p : bar.mesh.nodes) p += Vector3(0, 0.1 * p.x() * p.x(), 0.05 * p.x() * p.z());
  bar.ends = coupled_ends(bar.mesh);
  common::Progress silent;
  bar.response = respond(bar.mesh, {material}, bar.ends, {}, silent);
  // One step per unit wrench; its head, up to the first step, is turned into a buckling analysis.
  const std::string deck = calculix_deck("bar", bar.mesh, {material}, bar.ends);
  const std::size_t first = deck.find("*STEP"), load = deck.find("*CLOAD", first);
  ASSERT_NE(load, std::string::npos);
  const std::size_t line = deck.find('\n', load) + 1;
  const std::string node = deck.substr(line, deck.find(',', line) - line);
  const TemporaryFolder folder;
  folder.file("bar.inp", deck.substr(0, first) + "*STEP\n*BUCKLE\n1\n*CLOAD\n" + node +
                             ", 1, -1000.\n" + node + ", 3, 20.\n*END STEP\n");
  const std::string call = "cd '" + folder.path().string() + "' && ccx bar > ccx.log 2>&1";
  ASSERT_EQ(std::system(call.c_str()), 0) << io::read_text(folder.path() / "ccx.log");
  std::istringstream words(io::read_text(folder.path() / "bar.dat"));
  double factor = 0;
  int mode = 0;
  for (std::string text; std::getline(words, text);)
    if (std::istringstream row(text); row >> mode >> factor && mode == 1) break;
  Vector6 preload = push(1000);
  preload[2] = 20;
  // CalculiX leaves out what the forces on the rigid interface do in the second order of its
  // rotation (body_stress_stiffness), 0.3 % here; without it the two agree within 0.1 %.
  EXPECT_NEAR(bar.under(preload).buckling_free, factor, 5e-3 * factor);
}

TEST(GeometricStiffness, ChangesPerLoadAreTheDerivativeOfTheStiffness) {
  const Bar bar;
  Vector6 preload;
  preload << 3, -2, 1.5, 0.4, -0.3, 0.2;
  const auto at = [&](double factor) { return bar.under(factor * preload).stiffness; };
  const GeometricStiffness none = bar.under(Vector6::Zero());
  Matrix6 expected = Matrix6::Zero();
  for (std::size_t j = 0; j < 6; ++j)
    expected += preload[static_cast<Eigen::Index>(j)] * none.per_load[j];
  const double h = 1e-2;
  const Matrix6 slope = (at(h) - at(-h)) / (2 * h);
  const Vector6 d = none.stiffness.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 gap = d.asDiagonal() * (slope - expected) * d.asDiagonal();
  const Matrix6 size = d.asDiagonal() * expected * d.asDiagonal();
  EXPECT_LT(gap.cwiseAbs().maxCoeff(), 1e-5 * size.cwiseAbs().maxCoeff());
}

// The energy is that of the same link, seen from another point: t' = t + r x a + 1/2 r x (r x a).
TEST(GeometricStiffness, ReferencePointIsAMatterOfCoordinates) {
  const Vector3 arm(0.05, 0.03, -0.02);
  const Bar here, there(arm);
  Vector6 at_here;
  at_here << -300, 40, 25, 1, 2, 3;
  Vector6 at_there = at_here;
  at_there.tail<3>() -= arm.cross(at_here.head<3>());
  const GeometricStiffness a = here.under(at_here), b = there.under(at_there);
  Matrix6 shift = Matrix6::Identity();  // motion here from motion there
  shift.topRightCorner<3, 3>() = spatial::skew(arm);
  Matrix6 expected = shift.transpose() * a.stiffness * shift;
  // The motion of the first point has a second-order part, in which its force does work.
  const Matrix3 work = -at_here.head<3>() * arm.transpose();
  expected.bottomRightCorner<3, 3>() +=
      0.5 * (work + work.transpose()) - work.trace() * Matrix3::Identity();
  const Vector6 d = b.stiffness.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 gap = d.asDiagonal() * (b.stiffness - expected) * d.asDiagonal();
  EXPECT_LT(gap.cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_NEAR(a.buckling_held, b.buckling_held, 1e-6 * a.buckling_held);
}

TEST(GeometricStiffness, TurnsWithTheMesh) {
  const Matrix3 turn = spatial::exp_rotation(Vector3(0.4, -0.7, 1.1));
  Bar straight, turned;
  for (Vector3& p : turned.mesh.nodes) p = turn * p;
  turned.ends = coupled_ends(turned.mesh);
  common::Progress silent;
  turned.response = respond(turned.mesh, {material}, turned.ends, {}, silent);
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = turn;
  Vector6 preload;
  preload << -200, 30, -20, 2, 5, -3;
  const GeometricStiffness a = straight.under(preload), b = turned.under(both * preload);
  const Matrix6 back = both.transpose() * b.stiffness * both;
  const Vector6 d = a.stiffness.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
  const Matrix6 gap = d.asDiagonal() * (back - a.stiffness) * d.asDiagonal();
  EXPECT_LT(gap.cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_NEAR(a.buckling_free, b.buckling_free, 1e-6 * a.buckling_free);
}

// A rigid rotation of the whole mesh turns its internal forces: K_sigma (r x x) = r x f.
TEST(Prestress, ARigidRotationTurnsTheInternalForces) {
  for (const int order : {1, 2}) {
    TetMesh mesh = box_mesh({0.1, 0.02, 0.012}, 4, 2, 1);
    if (order == 2) mesh = with_mid_nodes(mesh);
    const auto count = static_cast<Eigen::Index>(mesh.nodes.size());
    Eigen::Matrix3Xd u(3, count), rotation(3, count);
    const Vector3 r(0.3, -0.5, 0.7);
    for (Eigen::Index n = 0; n < count; ++n) {
      const Vector3& p = mesh.nodes[static_cast<std::size_t>(n)];
      u.col(n) << p.x() * p.y(), p.z() - 2 * p.x() * p.x(), p.y() * p.z();
      rotation.col(n) = r.cross(p);
    }
    const Prestress prestress(mesh, {material}, u);
    const Eigen::Matrix3Xd forces = prestress.nodal_forces();
    EXPECT_LT((prestress.times(rotation) - spatial::skew(r) * forces).norm(),
              1e-12 * forces.norm());
    EXPECT_LT(prestress.times(Eigen::Matrix3Xd::Ones(3, count)).norm(), 1e-12 * forces.norm());
  }
}

TEST(GeometricStiffness, RefusesWhatNoLinkBears) {
  EXPECT_THROW(Bar().under(push(20 * Bar::euler())), BeyondBuckling);
}

}  // namespace
}  // namespace kinetostat::fea::geometric_stiffness_test
