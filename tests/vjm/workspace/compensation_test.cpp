#include "kinetostat/vjm/workspace/compensation.h"

#include <map>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::compensation_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

Robot shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

// Where the loaded platform stands when the actuators are commanded so: another way to the answer.
Vector6 error_with_commands(const Manipulator& manipulator, const Posture& commands,
                            const TargetPose& target) {
  std::map<std::string, double> values;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    for (const Eigen::Index k : chain.posture_coordinates())
      if (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::actuated)
        values[chain.name() + "." + chain.coordinates()[static_cast<std::size_t>(k)].name] =
            commands.coordinates[c][k];
  }
  const PostureResult posture = posture_from_joints(manipulator, values);
  EXPECT_TRUE(posture.reached) << posture.reason;
  const Equilibrium e = equilibrium_under_load(manipulator, posture.posture, target.load);
  return spatial::pose_difference(target.platform, e.platform);
}

TEST(Compensation, OneSpringIsCommandedForceOverStiffnessFurther) {
  ChainBuilder chain("slide");
  chain.actuator("x", Motion::tx, 1e6);
  const Compensation c = compensate(
      {"slide", {chain.build()}}, {Pose::translation({0.2, 0, 0}), {.force = {500, 0, 0}}},
      {.components = Components{true, false, false, false, false, false}});
  ASSERT_EQ(c.status, CompensationStatus::converged) << c.reason;
  EXPECT_NEAR(c.error[0], 5e-4, 2e-12);  // postures are found to 1e-12 m
  EXPECT_NEAR(c.corrected.coordinates[0][0], 0.2 - 5e-4, 2e-12);
  EXPECT_NEAR(c.residual[0], 0, 1e-13);
}

TEST(Compensation, MillingForcesAndAssemblyErrorsOfTheOrthoglideVanish) {
  const Robot robot = shipped("orthoglide_errors.yaml");
  const TargetPose target{Pose::translation({-0.07365, 0.02635, -0.07365}),
                          {.force = {215, -10, -25}, .moment = {1, 21.5, 0}}};
  const Compensation c = compensate(robot.manipulator, target);
  ASSERT_EQ(c.status, CompensationStatus::converged) << c.reason;
  EXPECT_EQ(c.components, (Components{true, true, true, false, false, false}));
  EXPECT_GT(c.error.head<3>().norm(), 1e-4);
  EXPECT_LT(c.residual.head<3>().norm(), 1e-11);
  EXPECT_LT((error_with_commands(robot.manipulator, c.corrected, target) - c.residual).norm(),
            1e-10);
  // Three actuators cannot take away the tilt.
  EXPECT_GT(c.residual.tail<3>().norm(), 1e-5);
}

TEST(Compensation, SixActuatorsMeetAllSixComponents) {
  const Robot robot = shipped("six_axis.yaml");
  const Posture home = posture_from_joints(robot.manipulator, {}).posture;
  const TargetPose target{home.platform, {.force = {500, 300, -2500}, .moment = {50, 0, -80}}};
  const Compensation c = compensate(robot.manipulator, target);
  ASSERT_EQ(c.status, CompensationStatus::converged) << c.reason;
  EXPECT_GT(c.error.head<3>().norm(), 1e-3);
  EXPECT_LT(c.residual.norm(), 1e-10);
  EXPECT_LT(error_with_commands(robot.manipulator, c.corrected, target).norm(), 1e-10);
}

// A planar arm sags out of its plane, where no command moves it: what it controls vanishes all the
// same, and it does not claim more.
TEST(Compensation, WhatIsNotControlledStaysAndSpoilsNothing) {
  const spatial::Matrix6 soft = 1e-7 * spatial::Matrix6::Identity();
  ChainBuilder chain("arm");
  chain.actuator("q1", Motion::rz, 2e4)
      .link("upper", Pose::translation({0.3, 0, 0}), spatial::Compliance6(soft))
      .actuator("q2", Motion::rz, 1e4)
      .link("fore", Pose::translation({0.25, 0, 0}), spatial::Compliance6(soft));
  const Manipulator arm("arm", {chain.build()});
  const TargetPose target{posture_from_joints(arm, {{"q1", 0.4}, {"q2", 0.9}}).posture.platform,
                          {.force = {80, -60, -200}}};
  const Compensation c = compensate(arm, target);
  ASSERT_EQ(c.status, CompensationStatus::converged) << c.reason;
  EXPECT_EQ(c.components, (Components{true, true, false, false, false, false}));
  EXPECT_LT(c.residual.head<2>().norm(), 1e-10);
  EXPECT_NEAR(c.residual[2], c.error[2], 0.05 * std::abs(c.error[2]));
}

TEST(Compensation, UnreachableTargetsAndLoadsEndWithTheReason) {
  const Robot robot = shipped("orthoglide.yaml");
  const Compensation far = compensate(robot.manipulator, {Pose::translation({5, 0, 0})});
  EXPECT_EQ(far.status, CompensationStatus::unreachable);
  EXPECT_NE(far.reason.find("cannot reach"), std::string::npos);
  const Robot loose = shipped("stewart_gough_a.yaml");
  const Compensation turning =
      compensate(loose.manipulator, {Pose::translation({0, 0, 0.6}), {.moment = {0, 0, 10}}});
  EXPECT_EQ(turning.status, CompensationStatus::no_equilibrium);
  EXPECT_NE(turning.reason.find("nothing resists"), std::string::npos);
  const Compensation crushed = compensate(robot.manipulator, {Pose(), {.force = {1e6, 1e6, 1e6}}});
  EXPECT_EQ(crushed.status, CompensationStatus::no_equilibrium);
  EXPECT_FALSE(crushed.reason.empty());
}

}  // namespace
}  // namespace kinetostat::vjm::compensation_test
