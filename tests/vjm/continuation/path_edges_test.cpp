// Paths at the edges of what a path is: nothing left to move, nothing that resists, the target met
// to rounding.
#include <cmath>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::path_edges_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

constexpr double k = 1e5;

Path trace_from(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
                const PathOptions& options = {}) {
  common::Progress progress;
  return trace(manipulator, posture, task, options, progress);
}

Path trace_from_home(const Manipulator& manipulator, const PathTask& task,
                     const PathOptions& options = {}) {
  return trace_from(manipulator, posture_from_joints(manipulator, {}).posture, task, options);
}

PathTask held(const Vector6& displacement) {
  PathTask task;
  task.displacement = displacement;
  return task;
}

PathTask loaded(const Vector3& force) {
  PathTask task;
  task.platform_held = false;
  task.growing.force = force;
  return task;
}

Robot shipped(const std::string& name) {
  return read_robot(std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data" / "robots" / name);
}

Manipulator beam() {
  ChainBuilder chain("beam");
  chain.link("beam", Pose::translation({1, 0, 0}),
             beam_compliance(1, Section::rectangle(0.02, 0.01, 0.3), {210e9, 80e9, std::nullopt},
                             BeamTheory::euler_bernoulli));
  return {"beam", {chain.build()}};
}

Manipulator slide() {
  ChainBuilder chain("slide");
  chain.actuator("x", Motion::tx, k);
  return {"slide", {chain.build()}};
}

// With the platform held, no motion is left inside: the same force as that of Newton's method.
void expect_the_force_of_newtons_method(const Manipulator& manipulator, const Posture& posture,
                                        const Vector6& displacement) {
  const Path path = trace_from(manipulator, posture, held(displacement));
  ASSERT_EQ(path.status, EquilibriumStatus::converged) << path.reason;
  EXPECT_EQ(path.branches[0].end, BranchEnd::target) << path.branches[0].reason;
  EXPECT_TRUE(path.critical.empty());
  ASSERT_EQ(path.at_target.size(), 1U);
  const Equilibrium expected =
      equilibrium_at_pose(manipulator, posture, spatial::displaced(posture.platform, displacement));
  const Vector6 wrench = expected.wrench.coordinates();
  EXPECT_GT(wrench.norm(), 0);
  EXPECT_LT((path.at_target[0].point.equilibrium.wrench.coordinates() - wrench).norm(),
            1e-8 * wrench.norm());
  EXPECT_TRUE(path.at_target[0].point.equilibrium.held.stable());
}

TEST(PathWithoutFreedom, ASerialArmThatIsHeld) {
  const Robot robot = shipped("six_axis.yaml");
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  for (int i = 0; i < 6; ++i)
    expect_the_force_of_newtons_method(robot.manipulator, posture, 1e-6 * Vector6::Unit(i));
}

TEST(PathWithoutFreedom, ASingularPlatformThatIsHeld) {
  const Robot robot = shipped("stewart_gough_a.yaml");
  const PostureResult at = posture_at(robot.manipulator, Pose::translation({0, 0, 0.6}));
  ASSERT_TRUE(at.reached) << at.reason;
  for (int i = 0; i < 3; ++i)
    expect_the_force_of_newtons_method(robot.manipulator, at.posture, 1e-3 * Vector6::Unit(i));
}

TEST(PathWithoutFreedom, ASingleBeamThatIsHeld) {
  const Manipulator robot = beam();
  const Posture posture = posture_from_joints(robot, {}).posture;
  for (int i = 0; i < 6; ++i)
    expect_the_force_of_newtons_method(robot, posture, 1e-4 * Vector6::Unit(i));
}

TEST(PathWithoutFreedom, OneSpringAlone) {
  const Path path = trace_from_home(slide(), held(1e-3 * Vector6::Unit(0)));
  EXPECT_EQ(path.branches[0].end, BranchEnd::target);
  ASSERT_EQ(path.at_target.size(), 1U);
  EXPECT_NEAR(path.at_target[0].point.along->force, 1e-3 * k, 1e-8 * k);
}

// A rigid robot under a load stands still and carries it; displaced, it cannot follow.
TEST(PathWithoutFreedom, ARigidRobot) {
  ChainBuilder chain("rigid");
  chain.actuator("q", Motion::rz, std::nullopt).offset(Pose::translation({0.3, 0, 0}));
  const Manipulator robot("rigid", {chain.build()});
  const Path carried = trace_from_home(robot, loaded({0, 500, 0}));
  EXPECT_EQ(carried.branches[0].end, BranchEnd::target) << carried.branches[0].reason;
  EXPECT_TRUE(carried.critical.empty());
  ASSERT_EQ(carried.at_target.size(), 1U);
  EXPECT_NEAR(carried.at_target[0].point.equilibrium.wrench.force.y(), 500, 1e-6);
  EXPECT_LT(carried.at_target[0].point.equilibrium.displacement.coordinates().norm(), 1e-12);

  const Path moved = trace_from_home(robot, held(1e-3 * Vector6::Unit(1)));
  EXPECT_TRUE(moved.at_target.empty());
  EXPECT_TRUE(moved.critical.empty());
  EXPECT_TRUE(moved.branches[0].end == BranchEnd::locked ||
              (moved.branches[0].end == BranchEnd::lost && !moved.branches[0].reason.empty()));
}

TEST(PathWithoutResistance, PassiveJointsAlone) {
  const Pose link = Pose::translation({0.3, 0, 0});
  ChainBuilder chain("loose");
  chain.passive("a", Motion::rz, 0.4).offset(link).passive("b", Motion::rz, -0.9).offset(link);
  chain.passive("c", Motion::rz);
  const Manipulator robot("loose", {chain.build()});
  const Path carried = trace_from_home(robot, loaded({0, 500, 0}));
  EXPECT_EQ(carried.branches[0].end, BranchEnd::lost);
  EXPECT_FALSE(carried.branches[0].reason.empty());
  EXPECT_TRUE(carried.at_target.empty());
  // Led, the end moves without any force, until the links are straight.
  const Path led = trace_from_home(robot, held(-0.1 * Vector6::Unit(0)));
  EXPECT_EQ(led.branches[0].end, BranchEnd::target) << led.branches[0].reason;
  ASSERT_EQ(led.at_target.size(), 1U);
  EXPECT_LT(led.at_target[0].point.equilibrium.wrench.coordinates().norm(), 1e-9);
  // Out of its plane it does not follow: the force grows, nothing moves.
  const Path blocked = trace_from_home(robot, held(0.1 * Vector6::Unit(2)));
  EXPECT_TRUE(blocked.at_target.empty());
  EXPECT_EQ(blocked.branches[0].end, BranchEnd::locked);
}

TEST(PathWithoutResistance, PulledBeyondItsReachItLocks) {
  const Pose link = Pose::translation({0.3, 0, 0});
  ChainBuilder chain("arm");
  chain.passive("a", Motion::rz, 0.4).offset(link).actuator("b", Motion::rz, 100.0, -0.8);
  chain.offset(link).passive("c", Motion::rz);
  const Path path =
      trace_from_home({"arm", {chain.build()}}, held(0.5 * Vector6::Unit(0)), {.most_points = 300});
  EXPECT_TRUE(path.at_target.empty());
  EXPECT_NE(path.branches[0].end, BranchEnd::target);
  EXPECT_LT(path.branches[0].points.back().parameter, 1);
}

TEST(PathWithoutTask, NothingGrowsAndNothingMoves) {
  for (const bool platform_held : {false, true}) {
    PathTask task;
    task.platform_held = platform_held;
    const Path path = trace_from_home(beam(), task);
    EXPECT_TRUE(path.critical.empty());
    for (const PathPoint& point : path.branches[0].points)
      EXPECT_LT(point.equilibrium.wrench.coordinates().norm(), 1e-9);
  }
}

// Equal steps come to the target with rounding only.
TEST(PathTarget, IsMetWithAnyNumberOfPoints) {
  for (const int points : {1, 2, 3, 5, 7, 10, 13, 20, 30, 49, 50, 64, 77, 100, 333})
    for (const double size : {1e-9, 1e-3, 0.7, 3.0}) {
      SCOPED_TRACE(testing::Message() << points << " points, " << size);
      for (const bool platform_held : {false, true}) {
        const PathTask task =
            platform_held ? held(size * Vector6::Unit(0)) : loaded({k * size, 0, 0});
        const Path path = trace_from_home(slide(), task, {.points = points});
        EXPECT_EQ(path.branches[0].end, BranchEnd::target);
        EXPECT_EQ(path.branches[0].points.back().parameter, 1);
        ASSERT_EQ(path.at_target.size(), 1U);
        EXPECT_EQ(path.at_target[0].point.parameter, 1);
        EXPECT_NEAR(path.at_target[0].point.along->deflection, size, 1e-9 * size);
        EXPECT_NEAR(path.at_target[0].point.along->force, k * size, 1e-9 * k * size);
        EXPECT_GE(path.branches[0].points.size(), static_cast<std::size_t>(points));
      }
    }
}

TEST(PathTarget, IsMetOnceOnTheWayToAHigherParameter) {
  for (const int points : {1, 10, 50, 64})
    for (const double highest : {1.0 + 1e-9, 1.5, 2.0, 3.0}) {
      const Path path = trace_from_home(slide(), loaded({k * 1e-3, 0, 0}),
                                        {.lowest = 0, .highest = highest, .points = points});
      EXPECT_EQ(path.at_target.size(), 1U) << points << " points to " << highest;
      EXPECT_EQ(path.branches[0].end, BranchEnd::range);
      EXPECT_EQ(path.branches[0].points.back().parameter, highest);
    }
}

TEST(PathTarget, LiesBeyondARangeThatEndsBefore) {
  for (const double highest : {1e-6, 0.5, 1 - 1e-9}) {
    const Path path = trace_from_home(slide(), held(1e-3 * Vector6::Unit(0)), {.highest = highest});
    EXPECT_TRUE(path.at_target.empty());
    EXPECT_EQ(path.branches[0].end, BranchEnd::range);
    EXPECT_NEAR(path.branches[0].points.back().parameter, highest, 1e-15);
  }
}

// Every shipped robot in several directions: the program ends, and every branch says how.
// With a moment the symmetric part of the tangent is singular beside the fold: one limit point.
TEST(PathUnderAMoment, CountsAFoldOnce) {
  struct Leg {
    double stiffness;
    Vector3 base, platform;
  };
  const Leg legs[] = {{4.967e7, {0.8164, -1.0223, 0.0209}, {0.1916, -0.0400, 0.0007}},
                      {4.889e7, {-0.2271, -0.1811, -0.0108}, {0.3092, 0.1090, -0.0152}},
                      {2.875e7, {-0.8080, -0.0928, -0.0433}, {-0.0366, 0.1081, 0.0581}},
                      {5.320e7, {1.3292, 0.0903, -0.0176}, {-0.0539, -0.0487, 0.0301}},
                      {4.631e7, {-0.1125, -0.2672, -0.0528}, {-0.1773, -0.0583, 0.0265}},
                      {4.731e7, {-0.1563, 0.1928, -0.0119}, {0.1161, 0.0183, 0.0201}}};
  std::vector<Chain> chains;
  for (const Leg& leg : legs) {
    ChainBuilder chain("leg" + std::to_string(chains.size()), Pose::translation(leg.base));
    chain.passive("ux", Motion::rx).passive("uy", Motion::ry);
    chain.actuator("l", Motion::tz, leg.stiffness, 0.8);
    chain.passive("sx", Motion::rx).passive("sy", Motion::ry).passive("sz", Motion::rz);
    chain.attach(Pose::translation(-leg.platform));
    chains.push_back(chain.build());
  }
  const Manipulator hexapod("hexapod", std::move(chains));
  const Pose at(spatial::exp_rotation(Vector3(0.1, -0.15, 0.2)), Vector3(0.05, -0.03, 0.75));
  const PostureResult posture = posture_at(hexapod, at);
  ASSERT_TRUE(posture.reached) << posture.reason;
  PathTask task = loaded(Vector3(20e3, -15e3, -60e3));
  task.growing.moment = Vector3(1e3, 2e3, -3e3);
  const Path path = trace_from(hexapod, posture.posture, task);
  const std::vector<PathPoint>& points = path.branches.front().points;
  int turns = 0;
  for (std::size_t k = 2; k < points.size(); ++k)
    turns += (points[k].parameter - points[k - 1].parameter) *
                         (points[k - 1].parameter - points[k - 2].parameter) <
                     0
                 ? 1
                 : 0;
  EXPECT_GE(turns, 1);
  EXPECT_EQ(static_cast<int>(path.critical.size()), turns);
  for (const CriticalPoint& critical : path.critical)
    EXPECT_EQ(critical.kind, CriticalKind::limit_point);
}

class ShippedRobots : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedRobots, AreFollowedInEveryDirection) {
  const Robot robot = shipped(GetParam());
  const PostureResult home = posture_from_joints(robot.manipulator, {});
  ASSERT_TRUE(home.reached) << home.reason;
  const PathOptions options{.points = 4, .most_points = 30, .branches = true, .most_branches = 4};
  std::vector<PathTask> tasks;
  for (const int i : {0, 2, 4}) {
    tasks.push_back(held(-0.01 * Vector6::Unit(i)));
    tasks.push_back(loaded(Vector3::Zero()));
    (i < 3 ? tasks.back().growing.force[i] : tasks.back().growing.moment[i - 3]) = -300;
  }
  for (const PathTask& task : tasks) {
    const Path path = trace_from(robot.manipulator, home.posture, task, options);
    if (path.status != EquilibriumStatus::converged) {
      EXPECT_FALSE(path.reason.empty());
      continue;
    }
    ASSERT_FALSE(path.branches.empty());
    for (const Branch& branch : path.branches) {
      ASSERT_FALSE(branch.points.empty());
      EXPECT_EQ(branch.end == BranchEnd::lost, !branch.reason.empty());
      if (branch.end == BranchEnd::target) {
        EXPECT_EQ(branch.points.back().parameter, 1);
        EXPECT_FALSE(path.at_target.empty());
      }
      for (const PathPoint& point : branch.points)
        EXPECT_TRUE(point.equilibrium.wrench.coordinates().allFinite());
    }
    for (const CriticalPoint& critical : path.critical)
      EXPECT_NE(critical.kind, CriticalKind::contact) << "no shipped robot has a stop";
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedRobots,
                         ::testing::Values("bench.yaml", "delta.yaml", "heavy_arm.yaml",
                                           "orthoglide.yaml", "orthoglide_errors.yaml",
                                           "orthoglide_prpar.yaml", "parallelogram.yaml",
                                           "six_axis.yaml", "six_axis_urdf.yaml",
                                           "stewart_gough_a.yaml", "stewart_gough_b.yaml",
                                           "translational_3puu.yaml", "urrs_a.yaml", "urrs_b.yaml",
                                           "urrs_c.yaml"));

}  // namespace
}  // namespace kinetostat::vjm::path_edges_test
