#include "kinetostat/vjm/statics/fixed_point.h"

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "vjm/random_chain.h"

namespace kinetostat::vjm::fixed_point_test {
namespace {

using spatial::Pose;
using spatial::Vector6;

Robot shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

class FixedPointOfOrthoglide : public ::testing::Test {
 protected:
  Robot robot = shipped("orthoglide.yaml");
  Posture posture = posture_at(robot.manipulator, Pose::translation({-0.02, 0.01, 0.03})).posture;
  Pose target = spatial::displaced(posture.platform, Vector6{5e-4, -3e-4, 4e-4, 1e-3, 0, -2e-3});
};

TEST_F(FixedPointOfOrthoglide, FindsTheEquilibriumOfNewtonsMethodAtAPose) {
  const FixedPoint fixed = fixed_point_at_pose(robot.manipulator, posture, target);
  const Equilibrium newton = equilibrium_at_pose(robot.manipulator, posture, target);
  ASSERT_TRUE(fixed.converged) << fixed.reason;
  EXPECT_LT((fixed.wrench.coordinates() - newton.wrench.coordinates()).norm(),
            1e-6 * newton.wrench.coordinates().norm());
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_LT((fixed.coordinates[c] - newton.chains[c].coordinates).norm(), 1e-9);
}

TEST_F(FixedPointOfOrthoglide, FindsTheEquilibriumOfNewtonsMethodUnderALoad) {
  const Load load{
      .force = {300, -200, 100}, .moment = {5, 0, 3}, .point_on_platform = {0, 0, 0.05}};
  const FixedPoint fixed = fixed_point_under_load(robot.manipulator, posture, load);
  const Equilibrium newton = equilibrium_under_load(robot.manipulator, posture, load);
  ASSERT_TRUE(fixed.converged) << fixed.reason;
  EXPECT_LT(spatial::pose_difference(fixed.platform, newton.platform).norm(), 1e-10);
}

// Linear: the ratio of successive changes settles, where Newton's method squares them.
TEST_F(FixedPointOfOrthoglide, ConvergesLinearly) {
  const FixedPoint fixed = fixed_point_at_pose(robot.manipulator, posture, target);
  const auto& c = fixed.changes;
  ASSERT_GE(c.size(), 5u);
  const double last = c[c.size() - 2] / c[c.size() - 3], before = c[c.size() - 3] / c[c.size() - 4];
  EXPECT_NEAR(last, before, 0.3 * before);
  EXPECT_GT(last, 1e-4);
}

TEST(FixedPointIteration, KeepsPreloadsAndAssemblyErrors) {
  ChainBuilder chain("leg");
  chain.actuator("x", Motion::tx, 1e6).passive("preloaded", Motion::tx, 2e6, 1e-3, 0.0);
  for (const Motion m : {Motion::ty, Motion::tz, Motion::rx, Motion::ry, Motion::rz})
    chain.actuator("other" + to_string(m), m, 1e6);
  const Manipulator one("one", {chain.build()});
  const Posture posture = posture_from_joints(one, {}).posture;
  // Two springs in series, one relaxed 1 mm further: held at zero they press with 1 mm k1
  // k2/(k1+k2).
  const FixedPoint fixed = fixed_point_at_pose(one, posture, Pose());
  ASSERT_TRUE(fixed.converged) << fixed.reason;
  EXPECT_NEAR(fixed.wrench.force.x(), -1e-3 * 2e6 / 3, 1e-6);
}

// Straight chain pushed beyond its critical force: Newton's method follows, the iteration does not.
TEST(FixedPointIteration, FailsBeyondTheCriticalForceAndSaysSo) {
  const Robot robot = shipped("orthoglide.yaml");
  const Posture posture =
      posture_at(robot.manipulator, Pose::translation({0.12635, 0.12635, 0.12635})).posture;
  const Pose target = spatial::displaced(posture.platform, Vector6{6e-3, 6e-3, 6e-3, 0, 0, 0});
  const FixedPoint fixed = fixed_point_at_pose(robot.manipulator, posture, target);
  EXPECT_FALSE(fixed.converged);
  EXPECT_NE(fixed.reason.find("eq. 10"), std::string::npos);
  EXPECT_EQ(fixed.reached, 0);
}

TEST(FixedPointIteration, RefusesWhatThePapersDoNotTreat) {
  for (const char* name : {"delta.yaml", "six_axis_urdf.yaml"}) {
    const Robot robot = shipped(name);
    const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
    EXPECT_THROW(fixed_point_under_load(robot.manipulator, posture, {.force = {1, 0, 0}}),
                 std::invalid_argument)
        << name;
  }
}

}  // namespace
}  // namespace kinetostat::vjm::fixed_point_test
