#include "kinetostat/vjm/statics/stability.h"

#include <cmath>
#include <functional>
#include <limits>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::vjm::stability_test {
namespace {

using spatial::Compliance6;
using spatial::Frame;
using spatial::Pose;
using spatial::Vector6;

Stability stability_of_all_motions(const Eigen::MatrixXd& hessian) {
  return stability_of(
      energy_spectrum({hessian, Eigen::MatrixXd::Identity(hessian.rows(), hessian.cols())}));
}

// A direction costs nothing where the terms of its energy cancel, not where its spring is soft.
TEST(Stability, CountsSignsAndNeutralDirections) {
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(5, 5);
  hessian.diagonal() << -2, 1e-18, 5, 7, 7;
  hessian(3, 4) = hessian(4, 3) = 7;
  const Stability s = stability_of_all_motions(hessian);
  EXPECT_EQ(s.unstable, 1);
  EXPECT_EQ(s.neutral, 1);
  EXPECT_EQ(s.margin, -2);
  EXPECT_TRUE(stability_of_all_motions(Eigen::MatrixXd(0, 0)).stable());
}

// Rigid motions that rotate coordinates into one another hide nothing: D and Q'DQ with Q orthogonal
// among the allowed motions have the same spectrum, down to 1e-16 of the largest.
TEST(Stability, SoftDirectionsKeepTheirDigitsBesideStiffOnes) {
  const Eigen::VectorXd values = Eigen::Vector4d(-1e-17, 1e-16, 3e-9, 5);
  const Eigen::MatrixXd mixed =
      Eigen::HouseholderQR<Eigen::MatrixXd>(
          (Eigen::Matrix4d() << 3, 1, 2, 1, 1, -1, 4, 2, 0, 2, 5, 1, 1, 7, -2, 1).finished())
          .householderQ();
  const EnergySpectrum spectrum = energy_spectrum({values.asDiagonal(), mixed});
  for (Eigen::Index i = 0; i < 4; ++i)
    EXPECT_NEAR(spectrum.values[i], values[i], 1e-9 * std::abs(values[i]));
  EXPECT_EQ(spectrum.neutral(), 0);
}

// A straight chain along x between pinned ends, pushed together by `shortening`.
Equilibrium pushed(const Manipulator& column, double shortening) {
  const Posture posture = posture_from_joints(column, {}).posture;
  return equilibrium_at_pose(column, posture,
                             spatial::displaced(posture.platform, -shortening * Vector6::Unit(0)));
}

double root(const std::function<double(double)>& f, double low, double high) {
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    ((f(middle) > 0) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Force at which the straight column loses its stability.
double critical_force(const Manipulator& column, double largest_shortening) {
  const double at =
      root([&](double s) { return pushed(column, s).held.margin; }, 0.0, largest_shortening);
  return -pushed(column, at).wrench.force.x();
}

// MMT11 section 6.1, model A: links of length L, one rotary spring K in each of the two actuators.
TEST(Stability, UrrsChainWithActuatorSpringsBucklesAtKOverL) {
  const double length = 0.3, k = 100, guide = 1e9;
  ChainBuilder chain("urrs");
  const Pose link = Pose::translation({length, 0, 0});
  chain.passive("u.Rz", Motion::rz).passive("u.Ry", Motion::ry).offset(link);
  chain.actuator("a1", Motion::rz, k).offset(link);
  chain.actuator("a2", Motion::rz, k).offset(link);
  chain.actuator("x", Motion::tx, guide);  // a stiff axial spring, so that the chain can be pushed
  chain.passive("s.Rx", Motion::rx).passive("s.Ry", Motion::ry).passive("s.Rz", Motion::rz);
  const Manipulator urrs("urrs", {chain.build()});
  EXPECT_NEAR(critical_force(urrs, 2 * k / length / guide), k / length, 4e-6 * k / length);
}

struct Column {
  int segments;
  double critical;  // in E I / L^2, from an independent program
};

class SegmentedColumn : public ::testing::TestWithParam<Column> {};

// Straight chain of three links, pinned ends, full coupled cantilever springs; exact: pi^2 / 9.
TEST_P(SegmentedColumn, BucklesWhereAnIndependentProgramSays) {
  const double length = 0.3;
  Section section;
  section.area = 0.04;  // hardly compressible, as the reference assumes
  section.second_moment_y = 1e-6;
  section.second_moment_z = 1e-9;
  section.torsion_constant = 1e-8;
  const Material steel{210e9, 80e9, std::nullopt};
  const int n = GetParam().segments;
  const Compliance6 piece =
      beam_compliance(length / n, section, steel, BeamTheory::euler_bernoulli);
  ChainBuilder chain("column");
  chain.passive("pin1", Motion::rz);
  for (int i = 0; i < 3 * n; ++i)
    chain.link("l" + std::to_string(i), Pose::translation({length / n, 0, 0}),
               Compliance6(piece.matrix()));
  chain.passive("pin2", Motion::rz);
  const Manipulator column("column", {chain.build()});
  const double unit = steel.young_modulus * section.second_moment_z / (length * length);
  const double shortening =
      3 * length * 2 * unit / (steel.young_modulus * section.area);  // at twice the unit force
  // The reference has four decimals and an axial stiffness of its own.
  EXPECT_NEAR(critical_force(column, shortening) / unit, GetParam().critical, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(ReferenceValues, SegmentedColumn,
                         ::testing::Values(Column{1, 1.5826}, Column{2, 1.2028}, Column{4, 1.1220},
                                           Column{8, 1.1029}));

TEST(Stability, AnUprightRodUnderADeadLoadFallsAboveKOverL) {
  const double length = 0.5, k = 40;
  ChainBuilder chain("rod");
  chain.actuator("q", Motion::rz, k).offset(Pose::translation({length, 0, 0}));
  const Manipulator rod("rod", {chain.build()});
  const Posture posture = posture_from_joints(rod, {}).posture;
  for (const double share : {0.99, 1.01}) {
    const Equilibrium e = equilibrium_under_load(rod, posture, {{-share * k / length, 0, 0}});
    ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    EXPECT_EQ(e.free.stable(), share < 1) << share;
    EXPECT_TRUE(e.held.stable());
  }
}

// A rod on a soft hinge beside a drive that is 1e18 times as stiff.
TEST(Stability, ASoftHingeBesideAStiffDriveBucklesAtKOverL) {
  const double length = 0.5, k = 1e-3;
  ChainBuilder chain("rod");
  chain.actuator("x", Motion::tx, 1e15).actuator("q", Motion::rz, k);
  chain.offset(Pose::translation({length, 0, 0}));
  const Manipulator rod("rod", {chain.build()});
  const Posture posture = posture_from_joints(rod, {}).posture;
  for (const double share : {0.1, 0.99, 1.01, 10.0}) {
    const Equilibrium e = equilibrium_under_load(rod, posture, {{-share * k / length, 0, 0}});
    ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    EXPECT_EQ(e.free.stable(), share < 1) << share;
    EXPECT_EQ(e.free.neutral, 0) << share;
  }
}

}  // namespace
}  // namespace kinetostat::vjm::stability_test
