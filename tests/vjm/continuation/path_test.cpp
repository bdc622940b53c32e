#include "kinetostat/vjm/continuation/path.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::path_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

constexpr double length = 0.3, k = 100;

// MMT11 section 6.1, model A: rigid links, one rotary spring K in each of the two actuators.
Manipulator urrs() {
  const Pose link = Pose::translation({length, 0, 0});
  ChainBuilder chain("urrs");
  chain.passive("u.Rz", Motion::rz).passive("u.Ry", Motion::ry).offset(link);
  chain.actuator("a1", Motion::rz, k).offset(link);
  chain.actuator("a2", Motion::rz, k).offset(link);
  chain.passive("s.Rx", Motion::rx).passive("s.Ry", Motion::ry).passive("s.Rz", Motion::rz);
  return {"urrs", {chain.build()}};
}

Path trace_quietly(const Manipulator& manipulator, const PathTask& task,
                   const PathOptions& options) {
  common::Progress progress;
  const Posture posture = posture_from_joints(manipulator, {}).posture;
  return trace(manipulator, posture, task, options, progress);
}

PathTask shortening(double by) {
  PathTask task;
  task.displacement = -by * Vector6::Unit(0);
  return task;
}

double force_of(const PathPoint& point) { return -point.equilibrium.wrench.force.x(); }

double at(const PathPoint& point, const std::string& joint, const Manipulator& manipulator) {
  return point.equilibrium.chains[0].coordinates[manipulator.chains()[0].index_of(joint)];
}

class ModelA : public ::testing::Test {
 protected:
  static Path traced() {
    PathOptions options;
    options.branches = true;
    return trace_quietly(urrs(), shortening(shortest), options);
  }
  static constexpr double shortest = 0.9 * length;
};

// In the straight posture the links lock: the force grows without any displacement until the
// springs give way, into a trapezoid at K / L and into a Z at 3 K / L.
TEST_F(ModelA, BifurcatesAtKOverLAndThreeKOverL) {
  const Path path = traced();
  std::vector<double> forces;
  for (const CriticalPoint& c : path.critical) {
    EXPECT_EQ(c.kind, CriticalKind::bifurcation);
    EXPECT_EQ(c.multiplicity, 1);
    if (c.branch == 0) forces.push_back(force_of(c.point) * length / k);
  }
  ASSERT_EQ(forces.size(), 2U);
  EXPECT_NEAR(forces[0], 1, 1e-8);
  EXPECT_NEAR(forces[1], 3, 3e-8);
  EXPECT_EQ(path.critical[0].unstable_before, 0);
  EXPECT_EQ(path.critical[1].unstable_after, 2);
}

// Trapezoid: F = (K/L) phi / sin(phi) with cos(phi) = 1 - Delta / (2 L).
TEST_F(ModelA, FollowsTheClosedFormOnTheTrapezoid) {
  const Manipulator robot = urrs();
  const Path path = traced();
  int branches = 0;
  for (const Branch& branch : path.branches) {
    if (branch.from != std::size_t{0}) continue;
    ++branches;
    EXPECT_EQ(branch.end, BranchEnd::target);
    EXPECT_GT(branch.points.size(), 50U);
    for (const PathPoint& point : branch.points) {
      const double phi = std::acos(1 - point.parameter * shortest / (2 * length));
      const double expected = phi < 1e-6 ? 1 : phi / std::sin(phi);
      EXPECT_NEAR(force_of(point) * length / k, expected, (phi < 1e-2 ? 1e-8 : 1e-9) * expected);
      EXPECT_NEAR(std::abs(at(point, "a1", robot)), phi, 1e-6);
      if (point.parameter > 1e-3) {
        EXPECT_TRUE(point.equilibrium.held.stable());
      }
    }
  }
  EXPECT_EQ(branches, 2) << "up and down";
}

// Z: the links at t, -s, t with sin(s) = 2 sin(t); by virtual work
// F = 2 K (t + s) (t' + s') / (L (2 sin(t) t' + sin(s) s')).
TEST_F(ModelA, FollowsTheClosedFormOnTheUnstableZ) {
  const Manipulator robot = urrs();
  const Path path = traced();
  int branches = 0;
  for (const Branch& branch : path.branches) {
    if (branch.from != std::size_t{1}) continue;
    ++branches;
    EXPECT_GT(branch.points.size(), 20U);
    for (const PathPoint& point : branch.points) {
      const double t = std::abs(at(point, "u.Rz", robot));
      if (t < 1e-4) continue;
      const double s = std::asin(2 * std::sin(t));
      const double rate = 2 * std::cos(t) / std::cos(s);
      const double expected = 2 * (t + s) * (1 + rate) / (2 * std::sin(t) + std::sin(s) * rate);
      // Beyond, the middle link stands across and the inverse sine takes the other value.
      if (point.parameter * shortest < 2 * length * (1 - std::sqrt(0.75)) + length - 1e-3) {
        EXPECT_NEAR(force_of(point) * length / k, expected, 1e-7 * expected);
      }
      EXPECT_NEAR(point.parameter * shortest, length * (3 - 2 * std::cos(t) - std::cos(s)), 1e-9);
      EXPECT_FALSE(point.equilibrium.held.stable());
    }
  }
  EXPECT_EQ(branches, 2);
}

TEST_F(ModelA, FindsAllEquilibriaAtOnePoseStableOnesFirst) {
  const Path path = traced();
  ASSERT_EQ(path.at_target.size(), 4U);
  const double phi = std::acos(1 - shortest / (2 * length));
  for (int i : {0, 1}) {
    const PathPoint& point = path.at_target[static_cast<std::size_t>(i)].point;
    EXPECT_TRUE(point.equilibrium.held.stable());
    EXPECT_NEAR(*point.potential, k * phi * phi, 1e-9 * k);
  }
  for (int i : {2, 3}) {
    const PathPoint& point = path.at_target[static_cast<std::size_t>(i)].point;
    EXPECT_FALSE(point.equilibrium.held.stable());
    EXPECT_GT(*point.potential, k * phi * phi);
  }
}

// Two bars with axial springs c between pinned supports 2 b apart, the apex h above them, pushed
// down by P at the apex: P = 2 c (l0 / l - 1) (h - w) with l^2 = b^2 + (h - w)^2.
class ShallowArch : public ::testing::Test {
 protected:
  static constexpr double b = 1, h = 0.2, c = 1e5;
  static inline const double l0 = std::hypot(b, h);

  // Rises to the apex, then falls: the end is held by a pin.
  static Manipulator arch() {
    const double slope = std::atan2(h, b);
    ChainBuilder chain("arch");
    chain.passive("pin1", Motion::rz, slope).offset(Pose::translation({l0, 0, 0}));
    chain.passive("bar1", Motion::tx, c, 0, 0).node("apex");
    chain.passive("hinge", Motion::rz, -2 * slope).offset(Pose::translation({l0, 0, 0}));
    chain.passive("bar2", Motion::tx, c, 0, 0).passive("pin2", Motion::rz, slope);
    return {"arch", {chain.build()}};
  }
  static double closed_form(double w) { return 2 * c * (l0 / std::hypot(b, h - w) - 1) * (h - w); }
  static double sink(const PathPoint& point) {
    const Eigen::VectorXd& x = point.equilibrium.chains[0].coordinates;
    return h - (l0 + x[1]) * std::sin(x[0]);
  }
  static Path traced(double push) {
    const Manipulator robot = arch();
    PathTask task;
    task.growing.nodes = {{0, robot.chains()[0].node_index("apex"), {0, -push, 0}}};
    return trace_quietly(robot, task, {});
  }
};

TEST_F(ShallowArch, SnapsThroughBothLimitPointsOnTheClosedForm) {
  // Limit points: dP/dw = 0 at (h - w)^2 = (l0^2 b^4)^(1/3) - b^2.
  const double rise = std::sqrt(std::cbrt(l0 * l0 * std::pow(b, 4)) - b * b);
  const double limit = closed_form(h - rise), push = 2 * limit;
  const Path path = traced(push);
  ASSERT_EQ(path.status, EquilibriumStatus::converged) << path.reason;
  ASSERT_EQ(path.branches.size(), 1U);
  EXPECT_EQ(path.branches[0].end, BranchEnd::target);
  for (const PathPoint& point : path.branches[0].points)
    EXPECT_NEAR(point.parameter * push, closed_form(sink(point)), 1e-9 * limit);
  ASSERT_EQ(path.critical.size(), 2U);
  for (const CriticalPoint& critical : path.critical)
    EXPECT_EQ(critical.kind, CriticalKind::limit_point);
  EXPECT_NEAR(path.critical[0].point.parameter * push, limit, 1e-8 * limit);
  EXPECT_NEAR(path.critical[1].point.parameter * push, -limit, 1e-8 * limit);
  EXPECT_NEAR(sink(path.critical[0].point), h - rise, 1e-7);
  EXPECT_NEAR(sink(path.critical[1].point), h + rise, 1e-7);
  EXPECT_EQ(path.critical[0].unstable_after, 1);
  EXPECT_EQ(path.critical[1].unstable_after, 0);
}

TEST_F(ShallowArch, WorkAlongThePathIsTheEnergyStored) {
  const double push = 3 * closed_form(0.05);
  const Path path = traced(push);
  const std::vector<PathPoint>& points = path.branches[0].points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double l = std::hypot(b, h - sink(points[i]));
    EXPECT_NEAR(points[i].equilibrium.energy, c * (l - l0) * (l - l0), 1e-9 * c * h * h);
    const double potential =
        points[i].equilibrium.energy - points[i].parameter * push * sink(points[i]);
    EXPECT_NEAR(*points[i].potential, potential, 1e-9 * c * h * h);
  }
}

// An upright rod on a rotary spring under a dead load: F L sin(q) = K q beyond K / L, both ways.
TEST(Path, ADeadLoadBifurcatesIntoTwoLeaningRods) {
  ChainBuilder chain("rod");
  chain.actuator("q", Motion::rz, k).offset(Pose::translation({length, 0, 0}));
  const Manipulator rod("rod", {chain.build()});
  PathTask task;
  task.platform_held = false;
  task.growing.force = {-1.5 * k / length, 0, 0};
  PathOptions options;
  options.branches = true;
  const Path path = trace_quietly(rod, task, options);
  ASSERT_EQ(path.critical.size(), 1U);
  EXPECT_NEAR(path.critical[0].point.parameter, 1 / 1.5, 1e-8);
  EXPECT_EQ(path.critical[0].kind, CriticalKind::bifurcation);
  ASSERT_EQ(path.branches.size(), 3U);
  double sides = 0;
  for (std::size_t b : {1U, 2U}) {
    EXPECT_EQ(path.branches[b].end, BranchEnd::target);
    for (const PathPoint& point : path.branches[b].points) {
      const double q = at(point, "q", rod);
      EXPECT_NEAR(1.5 * point.parameter * std::sin(q), q, 1e-8);
    }
    sides += std::copysign(1, at(path.branches[b].points.back(), "q", rod));
  }
  EXPECT_EQ(sides, 0);
  ASSERT_EQ(path.at_target.size(), 3U);
  EXPECT_LT(*path.at_target[0].point.potential, *path.at_target[2].point.potential);
  EXPECT_FALSE(path.at_target[2].point.equilibrium.free.stable());
}

// A gap of 0.1 rad before a hard stop: the rod leans freely, then is caught; a contact is not a
// bifurcation.
TEST(Path, AStopThatCatchesAnUnstableRodIsAContact) {
  ChainBuilder chain("rod");
  chain.passive("q", Motion::rz, k, 0, 0).offset(Pose::translation({length, 0, 0}));
  chain.law("q", std::make_shared<StopLaw>(-1e9, 0.1, 1e3 * k));
  const Manipulator rod("rod", {chain.build()});
  PathTask task;
  task.platform_held = false;
  task.growing.force = {-2 * k / length, 0, 0};
  task.growing.moment = {0, 0, 0.02 * k};
  task.constant = {};
  const Path path = trace_quietly(rod, task, {});
  EXPECT_EQ(path.branches[0].end, BranchEnd::target);
  for (const PathPoint& point : path.branches[0].points) {
    const double q = at(point, "q", rod);
    const double stop = q > 0.1 ? 1e3 * k * (q - 0.1) : 0;
    EXPECT_NEAR(point.parameter * (2 * k * std::sin(q) + 0.02 * k), k * q + stop, 1e-8 * k);
  }
}

TEST(Path, EndsWithTheReasonWhereThePosturesEnd) {
  // Pulled straight: the force grows without bound and no displacement is left.
  const Manipulator robot = urrs();
  common::Progress progress;
  const Posture bent = posture_from_joints(robot, {{"a1", 0.5}, {"a2", 0.5}}).posture;
  PathTask task = shortening(-length);
  PathOptions options;
  options.most_points = 200;
  const Path path = trace(robot, bent, task, options, progress);
  EXPECT_EQ(path.branches[0].end, BranchEnd::locked);
  EXPECT_LT(path.branches[0].points.back().parameter, 1);
  EXPECT_TRUE(path.at_target.empty());
}

}  // namespace
}  // namespace kinetostat::vjm::path_test
