#include "kinetostat/vjm/uncertainty/propagation.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/spring_shares.h"
#include "kinetostat/vjm/uncertainty/deflection_numbers.h"
#include "kinetostat/vjm/uncertainty/draws.h"
#include "kinetostat/vjm/uncertainty/stiffness_numbers.h"

#include "support/matrix_near.h"
#include "vjm/robot_text.h"
#include "vjm/uncertainty/stated_robot.h"

namespace kinetostat::vjm::propagation_test {
namespace {

using spatial::Matrix6;
using spatial::Vector3;
constexpr Eigen::Index along = StiffnessNumbers::along;

Posture home(const Robot& robot) {
  const PostureResult result = posture_from_joints(robot.manipulator, {});
  EXPECT_TRUE(result.reached) << result.reason;
  return result.posture;
}

Propagation of_stiffness(const Robot& robot, const Vector3& direction, int threads = 1) {
  common::Progress progress;
  const Posture posture = home(robot);
  return propagate(
      robot, [&](const Robot& r) { return stiffness_numbers(r, posture, direction); }, threads,
      progress);
}

Robot two_slides(const std::string& a, const std::string& b, const std::string& rest = {}) {
  return robot_from(
      "kinetostat: 1\nname: slides\nunits: {length: mm, force: N}\nchain_types:\n  slides:\n"
      "    - actuator: {name: a, axis: Tx, stiffness: " +
      a +
      "}\n"
      "    - actuator: {name: b, axis: Tx, stiffness: " +
      b +
      "}\n"
      "    - passive: {name: u, axes: [Ty, Tz, Rx, Ry, Rz]}\n" +
      rest + "manipulator: {chain: slides}\n");
}

// Two slides and a rigid rest: the compliance along x is 1/a + 1/b.
std::optional<Eigen::VectorXd> series(const Robot& robot) {
  double sum = 0;
  for (const Spring& s : robot.manipulator.chains()[0].springs()) sum += 1 / s.stiffness(0, 0);
  return Eigen::VectorXd::Constant(1, sum);
}

Propagation of_series(const Robot& robot) {
  common::Progress progress;
  return propagate(robot, series, 1, progress);
}

// u_c^2 = (u_a/a^2)^2 + (u_b/b^2)^2.
TEST(Propagation, OfTwoSpringsInSeriesIsTheClosedForm) {
  const Propagation p = of_series(two_slides("{value: 1000, sd: 50}", "{value: 3000, sd: 300}"));
  const double of_a = 5e4 / 1e12, of_b = 3e5 / 9e12;
  EXPECT_NEAR(p.estimate[0], 1e-6 + 1 / 3e6, 1e-18);
  EXPECT_NEAR(p.parts(0, 0), -of_a, 1e-8 * of_a);
  EXPECT_NEAR(p.parts(0, 1), -of_b, 1e-8 * of_b);
  EXPECT_NEAR(p.expanded(0), 2 * std::hypot(of_a, of_b), 1e-8 * of_a);
  EXPECT_NEAR(p.shares(0)[0], of_a * of_a / (of_a * of_a + of_b * of_b), 1e-8);
  EXPECT_NEAR(p.shares(0).sum(), 1, 1e-14);
}

// GUM eq. 16: u^2 = p_a^2 + p_b^2 + 2 r p_a p_b.
TEST(Propagation, CorrelatedSourcesAddUpByTheirCorrelation) {
  const std::string correlations =
      "correlations: [{of: stiffness of a, with: {stiffness of b: -0.8}}]\n";
  const Propagation p =
      of_series(two_slides("{value: 1000, sd: 50}", "{value: 3000, sd: 300}", correlations));
  const double of_a = 5e4 / 1e12, of_b = 3e5 / 9e12;
  const double variance = of_a * of_a + of_b * of_b - 1.6 * of_a * of_b;
  EXPECT_NEAR(p.deviation(0), std::sqrt(variance), 1e-8 * of_a);
  EXPECT_NEAR(p.shares(0)[1], (of_b * of_b - 0.8 * of_a * of_b) / variance, 1e-7);
  EXPECT_LT(p.shares(0)[1], 0);
  EXPECT_NEAR(p.shares(0).sum(), 1, 1e-14);
  EXPECT_NEAR(p.covariance()(0, 0), variance, 1e-7 * variance);
}

TEST(Propagation, WhatIsCertainHasNoShares) {
  common::Progress progress;
  const Robot robot = two_slides("{value: 1000, sd: 50}", "3000");
  const Propagation p = propagate(
      robot, [](const Robot&) { return Eigen::VectorXd::Ones(1); }, 1, progress);
  EXPECT_EQ(p.deviation(0), 0);
  EXPECT_EQ(p.shares(0)[0], 0);
}

// A serial chain: dC/dk = -J J' / k^2 for a joint, and with nu held dC/dE = -J C_link J' / E.
TEST(Propagation, OfASerialArmIsTheClosedFormInAllEntries) {
  const Robot robot = stated_robot("six_axis_urdf.yaml", 0.1);
  ASSERT_EQ(robot.sources.size(), 7u);
  const Propagation p = of_stiffness(robot, Vector3::UnitX());
  const Chain& chain = robot.manipulator.chains()[0];
  ChainKinematics kinematics;
  evaluate(chain, home(robot).coordinates[0], kinematics);
  for (std::size_t s = 0; s < robot.sources.size(); ++s) {
    Matrix6 expected = Matrix6::Zero();
    for (const Spring& spring : chain.springs()) {
      const bool is_link = spring.stiffness.rows() == 6;
      if (robot.sources[s].name != (is_link ? "E of aluminium" : "stiffness of " + spring.name))
        continue;
      const Eigen::MatrixXd j =
          kinematics.jacobian.middleCols(spring.first, spring.stiffness.rows());
      expected -= 0.1 * j * spring.stiffness.inverse() * j.transpose();
    }
    ASSERT_FALSE(expected.isZero(0)) << robot.sources[s].name;
    const Matrix6 part = p.parts.col(static_cast<Eigen::Index>(s))
                             .segment<36>(StiffnessNumbers::compliance)
                             .reshaped<Eigen::RowMajor>(6, 6);
    // Every spring passes rounding of the whole compliance on.
    EXPECT_TRUE(test::matrix_near_relative(part, expected, 1e-6)) << robot.sources[s].name;
  }
}

// Closed chains: what a spring takes of the compliance is its derivative (Castigliano).
TEST(Propagation, OfAParallelRobotIsTheShareOfItsSprings) {
  const Robot robot = stated_robot("orthoglide.yaml", 0.05);
  const Vector3 direction = Vector3(0.3, -0.5, 0.8).normalized();
  const Propagation p = of_stiffness(robot, direction);
  double of_drives = 0;
  for (const SpringShare& s : spring_shares(robot.manipulator, home(robot), direction))
    if (s.spring == "rho") of_drives += s.share;
  ASSERT_EQ(p.sources.back().name, "stiffness of rho");
  EXPECT_NEAR(p.parts(along, p.parts.cols() - 1), -0.05 * of_drives * p.estimate[along],
              1e-5 * 0.05 * p.estimate[along]);
}

std::size_t chain_with(const Manipulator& manipulator, const std::string& joint) {
  std::size_t c = 0;
  while (!manipulator.chains().at(c).has_coordinate(joint)) ++c;
  return c;
}

// Under a load, against the exact derivatives of the solution.
TEST(Propagation, OfALoadedRobotIsTheExactDerivative) {
  const Robot robot = stated_robot("heavy_arm.yaml", 0.05);
  const Posture posture = home(robot);
  const Load load{.force = Vector3(300, -500, -2000)};
  common::Progress progress;
  const Propagation p = propagate(
      robot,
      [&](const Robot& r) {
        return deflection_numbers(equilibrium_under_load(r.manipulator, posture, load));
      },
      1, progress);
  const Equilibrium equilibrium = equilibrium_under_load(robot.manipulator, posture, load);
  for (std::size_t s = 0; s < robot.sources.size(); ++s) {
    const std::string& name = robot.sources[s].name;
    if (!name.starts_with("stiffness of q")) continue;
    const std::string joint = name.substr(13);
    const Matrix6X exact =
        displacement_by_log_stiffness(robot.manipulator, posture, load, equilibrium,
                                      {{chain_with(robot.manipulator, joint), joint}});
    const Vector3 part =
        p.parts.col(static_cast<Eigen::Index>(s)).segment<3>(DeflectionNumbers::displacement);
    EXPECT_TRUE(test::matrix_near_relative(part, Vector3(0.05 * exact.col(0).head<3>()), 1e-6))
        << name;
  }
}

TEST(Propagation, SharesOfEveryShippedRobotAddUpToOne) {
  for (const char* name :
       {"six_axis.yaml", "delta.yaml", "orthoglide.yaml", "translational_3puu.yaml",
        "stewart_gough_b.yaml", "six_axis_urdf.yaml", "gantry.yaml"}) {
    const Robot robot = std::string(name) == "gantry.yaml" ? read_robot(shipped_robot(name))
                                                           : stated_robot(name, 0.1);
    ASSERT_FALSE(robot.sources.empty()) << name;
    const Propagation p = of_stiffness(robot, Vector3(1, 2, -1).normalized());
    EXPECT_NEAR(p.shares(along).sum(), 1, 1e-12) << name;
    EXPECT_GE(p.shares(along).minCoeff(), 0) << name;
    EXPECT_GT(p.deviation(along), 0) << name;
  }
}

TEST(Propagation, NamesTheSourceBesideWhichNothingStands) {
  const Robot robot = two_slides("{value: 1000, sd: 50}", "{value: 3000, sd: 300}");
  const Computation stiff_only = [](const Robot& r) {
    const auto& springs = r.manipulator.chains()[0].springs();
    return springs[1].stiffness(0, 0) < 3e6 * (1 - 1e-9) ? std::nullopt : series(r);
  };
  common::Progress progress;
  try {
    (void)propagate(robot, stiff_only, 1, progress);
    FAIL() << "computed";
  } catch (const common::NoConvergence& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("beside the estimate of the stiffness of b"));
  }
}

// A cantilever of Euler and Bernoulli with a mass at its end, under a force there: w = F L^3 / 3 E
// I, where its weight is the force.
const char* const cantilever = R"(kinetostat: 1
name: cantilever
units: {length: m, force: N, angle: rad}
gravity: {direction: [0, 0, -1]}
materials: {steel: {E: 210 GPa, nu: 0.3}}
links:
  bar: {beam: {length: {value: 0.5, sd: 0.4 %}, section: {circle: {diameter: 0.02}}, material: steel,
               theory: euler-bernoulli}}
chain_types:
  arm: [{link: bar}, {mass: {name: load, mass: {value: 3 kg, sd: 2 %}}}]
manipulator: {chain: arm}
)";

TEST(Propagation, OfALengthIsThreefoldInACantileverAndOfAMassOnefold) {
  const Robot robot = robot_from(cantilever);
  ASSERT_EQ(robot.sources.size(), 2u);
  EXPECT_EQ(robot.sources[0].name, "length of bar");
  EXPECT_EQ(robot.sources[0].kind, SourceKind::length);
  EXPECT_EQ(robot.sources[1].name, "mass of load");
  EXPECT_EQ(robot.sources[1].kind, SourceKind::mass);
  EXPECT_TRUE(have_other_postures(robot));
  common::Progress progress;
  // Each robot from where it stands without load: a longer bar is no deflection.
  const Propagation found = propagate(
      robot,
      [](const Robot& r) {
        return deflection_numbers(equilibrium_under_load(r.manipulator, home(r), {}));
      },
      1, progress);
  const Eigen::Index moved = DeflectionNumbers::moved;
  const double sag = 3 * 9.80665 * std::pow(0.5, 3) / (3 * 210e9 * M_PI / 64 * std::pow(0.02, 4));
  EXPECT_NEAR(found.value[moved], sag, 1e-4 * sag);
  EXPECT_NEAR(std::abs(found.parts(moved, 0)), 3 * 0.004 * sag, 1e-3 * 0.012 * sag);
  EXPECT_NEAR(std::abs(found.parts(moved, 1)), 0.02 * sag, 1e-3 * 0.02 * sag);
}

TEST(Propagation, DoesNotDependOnTheNumberOfThreads) {
  const Robot robot = stated_robot("delta.yaml", 0.1);
  EXPECT_EQ(of_stiffness(robot, Vector3::UnitZ(), 1).parts,
            of_stiffness(robot, Vector3::UnitZ(), 3).parts);
}

}  // namespace
}  // namespace kinetostat::vjm::propagation_test
