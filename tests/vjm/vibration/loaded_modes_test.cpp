// Modes about an equilibrium under load: closed forms, and the compliance that statics finds.
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::vjm::loaded_modes_test {
namespace {

using spatial::Pose;
using spatial::Vector3;

constexpr double length = 0.8, mass = 3, gravity = 9.81;

Posture home(const Manipulator& manipulator) {
  return posture_from_joints(manipulator, {}).posture;
}

double squared(const ManipulatorMode& mode) { return std::pow(2 * M_PI * mode.frequency, 2); }

double first(const Manipulator& manipulator, const Load& load) {
  const NaturalModes found = natural_modes(manipulator, home(manipulator), load, 3);
  EXPECT_EQ(found.modes.size(), 1u);
  EXPECT_EQ(found.free_motions, 0);
  return squared(found.modes.at(0));
}

// A particle at the end of a rod without mass, on a drive of this stiffness.
Manipulator standing(double stiffness) {
  return Manipulator("rod", {ChainBuilder("rod", Pose())
                                 .actuator("q", Motion::ry, stiffness)
                                 .offset(Pose::translation({0, 0, length}))
                                 .mass("tip", mass, Vector3::Zero())
                                 .build()})
      .with_gravity({0, 0, -gravity});
}

TEST(LoadedModes, WhatHangsIsAPendulum) {
  const Manipulator pendulum =
      Manipulator("pendulum", {ChainBuilder("pendulum", Pose())
                                   .passive("q", Motion::ry)
                                   .offset(Pose::translation({0, 0, -length}))
                                   .mass("bob", mass, Vector3::Zero())
                                   .build()})
          .with_gravity({0, 0, -gravity});
  EXPECT_NEAR(first(pendulum, {}), gravity / length, 1e-8 * gravity / length);
  // At rest nothing holds it.
  EXPECT_EQ(natural_modes(pendulum, home(pendulum), 3).free_motions, 1);
}

TEST(LoadedModes, WhatStandsIsSofterByItsWeightAndStifferByAPull) {
  const double k = 400, push = mass * gravity;
  for (const double pull : {0.0, 100.0, -200.0}) {
    const double expected = (k - push * length + pull * length) / (mass * length * length);
    EXPECT_NEAR(first(standing(k), {.force = {0, 0, pull}}), expected, 1e-8 * expected) << pull;
  }
}

TEST(LoadedModes, WhatFallsOverHasNone) {
  const Manipulator rod = standing(0.9 * mass * gravity * length);
  EXPECT_THROW((void)natural_modes(rod, home(rod), Load(), 3), common::NoConvergence);
  EXPECT_NO_THROW((void)natural_modes(rod, home(rod), Load{.force = {0, 0, 10}}, 3));
}

// Two rods on springs in a line, pushed along it.
TEST(LoadedModes, APushedColumnOfTwoRodsIsTheDoublePendulumWithItsGeometricStiffness) {
  const double l1 = 0.7, l2 = 0.5, m1 = 3, m2 = 2, k1 = 4e4, k2 = 1.5e4;
  const Manipulator column("column", {ChainBuilder("column", Pose())
                                          .actuator("q1", Motion::rz, k1)
                                          .offset(Pose::translation({l1, 0, 0}))
                                          .mass("elbow", m1, Vector3::Zero())
                                          .actuator("q2", Motion::rz, k2)
                                          .offset(Pose::translation({l2, 0, 0}))
                                          .mass("tip", m2, Vector3::Zero())
                                          .build()});
  Eigen::Matrix2d m, k, of_push;
  m << m1 * l1 * l1 + m2 * (l1 + l2) * (l1 + l2), m2 * l2 * (l1 + l2), m2 * l2 * (l1 + l2),
      m2 * l2 * l2;
  k << k1, 0, 0, k2;
  of_push << l1 + l2, l2, l2, l2;
  for (const double push : {0.0, 1e4, -1e4}) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> exact(k - push * of_push, m);
    const NaturalModes found = natural_modes(column, home(column), Load{.force = {-push, 0, 0}}, 3);
    ASSERT_EQ(found.modes.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const double omega_squared = exact.eigenvalues()[static_cast<Eigen::Index>(i)];
      EXPECT_NEAR(squared(found.modes[i]), omega_squared, 1e-7 * omega_squared) << push;
      double sum = 0;
      for (const SpringShare& share : found.modes[i].springs) sum += share.share;
      EXPECT_NEAR(sum, 1, 1e-9);
    }
  }
}

// At 0 Hz the motions of K y = J'F are the compliance of the loaded manipulator.
class Shipped : public testing::TestWithParam<const char*> {};

TEST_P(Shipped, AnswersAtRestAsStaticsUnderTheSameLoad) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + GetParam() + ".yaml");
  const Load load{.force = {300, -200, -500}};
  const Posture posture = home(robot.manipulator);
  const Equilibrium equilibrium = equilibrium_under_load(robot.manipulator, posture, load);
  ASSERT_TRUE(equilibrium.compliance) << equilibrium.reason;
  const SmallMotions motions = small_motions(robot.manipulator, posture, load);
  const Eigen::MatrixXd answer =
      motions.platform * motions.stiffness.inverse() * motions.platform.transpose();
  const spatial::Matrix6& expected = equilibrium.compliance->matrix();
  EXPECT_LT((answer - expected).norm(), 1e-7 * expected.norm());
  // It is not that without load.
  const SmallMotions unloaded = small_motions(robot.manipulator, posture);
  const Eigen::MatrixXd at_rest =
      unloaded.platform * unloaded.stiffness.inverse() * unloaded.platform.transpose();
  EXPECT_GT((answer - at_rest).norm(), 1e-6 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(All, Shipped,
                         testing::Values("heavy_arm", "orthoglide", "gantry", "orthoglide_frame"),
                         [](const auto& given) { return std::string(given.param); });

}  // namespace
}  // namespace kinetostat::vjm::loaded_modes_test
