// Branches of paths: each once, and each critical point by its right name. Closed forms.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::path_branches_test {
namespace {

using spatial::Pose;
using spatial::Vector6;

constexpr double pi = std::numbers::pi;

Path trace_quietly(const Manipulator& manipulator, const PathTask& task,
                   const PathOptions& options) {
  common::Progress progress;
  const Posture posture = posture_from_joints(manipulator, {}).posture;
  return trace(manipulator, posture, task, options, progress);
}

double coordinate(const PathPoint& point, Eigen::Index k) {
  return point.equilibrium.chains[0].coordinates[k];
}

std::size_t count(const Path& path, CriticalKind kind) {
  return static_cast<std::size_t>(std::count_if(path.critical.begin(), path.critical.end(),
                                                [&](const auto& c) { return c.kind == kind; }));
}

std::size_t count(const Path& path, BranchEnd end) {
  return static_cast<std::size_t>(std::count_if(path.branches.begin(), path.branches.end(),
                                                [&](const auto& b) { return b.end == end; }));
}

// A crank of radius r turns freely about the origin; a spring c of length l0 runs from its pin to
// the point (d, 0). The pin is pushed towards -x by p times P. With l the length of the spring,
// equilibrium is sin(phi) = 0, or p P = c d (1 - l0 / l): a loop that the crank turns around.
class Crank : public ::testing::Test {
 protected:
  static constexpr double r = 0.3, d = 0.7, c = 1000, l0 = 0.72;

  static Path traced(double push, double first_angle_sign = 1) {
    const double phi = first_angle_sign * std::acos((r * r + d * d - l0 * l0) / (2 * r * d));
    const double rod = std::atan2(-r * std::sin(phi), d - r * std::cos(phi));
    ChainBuilder chain("crank");
    chain.passive("crank", Motion::rz, phi).offset(Pose::translation({r, 0, 0})).node("pin");
    chain.passive("pin", Motion::rz, rod - phi).offset(Pose::translation({l0, 0, 0}));
    chain.passive("spring", Motion::tx, c, 0, 0).passive("end", Motion::rz, -rod);
    PathTask task;
    task.growing.nodes = {{0, chain.so_far().node_index("pin"), {-push, 0, 0}}};
    PathOptions options;
    options.branches = true;
    return trace_quietly({"crank", {chain.build()}}, task, options);
  }
};

TEST_F(Crank, TurnsOnceAroundAndIsBackWhereItBegan) {
  const Path path = traced(1000);
  ASSERT_FALSE(path.branches.empty());
  EXPECT_EQ(path.branches[0].end, BranchEnd::closed);
  const std::vector<PathPoint>& points = path.branches[0].points;
  EXPECT_NEAR(std::abs(coordinate(points.back(), 0) - coordinate(points.front(), 0)), 2 * pi, 0.1);
  for (const PathPoint& point : points) {
    const double l = std::sqrt(r * r + d * d - 2 * r * d * std::cos(coordinate(point, 0)));
    EXPECT_NEAR(point.parameter, c * d * (1 - l0 / l) / 1000, 1e-9);
  }
}

// Where the loop passes the dead centres the straight branches cross it: two bifurcations, no limit
// points, four further branches.
TEST_F(Crank, MeetsBothStraightBranchesOnce) {
  const Path path = traced(1000);
  ASSERT_EQ(path.critical.size(), 2U);
  EXPECT_EQ(count(path, CriticalKind::bifurcation), 2U);
  EXPECT_NEAR(path.critical[0].point.parameter, c * d * (1 - l0 / (d + r)) / 1000, 1e-8);
  EXPECT_NEAR(path.critical[1].point.parameter, c * d * (1 - l0 / (d - r)) / 1000, 1e-8);
  ASSERT_EQ(path.branches.size(), 5U);
  EXPECT_EQ(count(path, BranchEnd::target), 2U);
  EXPECT_EQ(count(path, BranchEnd::range), 2U);
  ASSERT_EQ(path.at_target.size(), 2U);
  for (const TargetPoint& target : path.at_target)
    EXPECT_NEAR(std::sin(coordinate(target.point, 0)), 0, 1e-9);
  EXPECT_EQ(path.not_tried, 0U);
}

// The same with the crank folded the other way at the start, and with a load so small that the loop
// leaves the range on both sides.
TEST_F(Crank, LeavesTheRangeWhereTheLoadIsTooSmall) {
  for (const double side : {1.0, -1.0}) {
    const Path path = traced(100, side);
    ASSERT_EQ(path.branches.size(), 1U);
    EXPECT_EQ(path.branches[0].end, BranchEnd::target);
    ASSERT_EQ(path.at_target.size(), 1U);
    const double l = l0 / (1 - 100 / (c * d));
    EXPECT_NEAR(std::cos(coordinate(path.at_target[0].point, 0)),
                (r * r + d * d - l * l) / (2 * r * d), 1e-9);
  }
}

// A sprung joint knows how often it has turned: k q = M.
TEST(Branches, FullTurnsOfASprungJointAreDifferentStates) {
  ChainBuilder chain("rod");
  chain.actuator("q", Motion::rz, 100.0).offset(Pose::translation({0.3, 0, 0}));
  PathTask task;
  task.platform_held = false;
  task.growing.moment = {0, 0, 100 * 15.0};
  const Path path = trace_quietly({"rod", {chain.build()}}, task, {});
  EXPECT_EQ(path.branches[0].end, BranchEnd::target);
  EXPECT_TRUE(path.critical.empty());
  ASSERT_EQ(path.at_target.size(), 1U);
  EXPECT_NEAR(coordinate(path.at_target[0].point, 0), 15, 1e-9);
}

// k (q - a) = P L sin(q): a rod that rests at the angle a, beyond half a turn; it falls back
// towards pi and never passes it.
TEST(Branches, ARodThatRestsBeyondHalfATurnFollowsTheClosedForm) {
  constexpr double k = 100, length = 0.3, rest = 4, load = 5 * k / length;
  ChainBuilder chain("rod");
  chain.actuator("q", Motion::rz, k, rest).offset(Pose::translation({length, 0, 0}));
  PathTask task;
  task.platform_held = false;
  task.growing.force = {-load, 0, 0};
  const Path path = trace_quietly({"rod", {chain.build()}}, task, {});
  EXPECT_EQ(path.branches[0].end, BranchEnd::target);
  EXPECT_TRUE(path.critical.empty());
  for (const PathPoint& point : path.branches[0].points) {
    const double q = coordinate(point, 0);
    EXPECT_GT(q, pi);
    EXPECT_NEAR(k * (q - rest), point.parameter * load * length * std::sin(q), 1e-8 * k);
  }
}

// Post-buckling of the upright rod: q / sin(q) = P L / k. Whatever the load, three equilibria are
// connected with the upright one, and one bifurcation.
TEST(Branches, APendulumHasOnePitchforkAtEveryLoad) {
  constexpr double k = 100, length = 0.3;
  ChainBuilder chain("rod");
  chain.actuator("q", Motion::rz, k).offset(Pose::translation({length, 0, 0}));
  for (const double load : {1.001, 1.5, 4.0, 40.0}) {
    SCOPED_TRACE(load);
    PathTask task;
    task.platform_held = false;
    task.growing.force = {-load * k / length, 0, 0};
    PathOptions options;
    options.branches = true;
    const Path path = trace_quietly({"rod", {chain.build()}}, task, options);
    ASSERT_EQ(path.critical.size(), 1U);
    EXPECT_EQ(path.critical[0].kind, CriticalKind::bifurcation);
    EXPECT_NEAR(path.critical[0].point.parameter, 1 / load, 1e-8);
    EXPECT_EQ(path.branches.size(), 3U);
    ASSERT_EQ(path.at_target.size(), 3U);
    EXPECT_EQ(count(path, BranchEnd::target), 3U);
    double sum = 0;
    for (const TargetPoint& target : path.at_target) {
      const double q = coordinate(target.point, 0);
      EXPECT_NEAR(load * std::sin(q), q, 1e-8);
      EXPECT_LT(std::abs(q), pi);
      sum += q;
    }
    EXPECT_NEAR(sum, 0, 1e-7);
    EXPECT_GT(std::abs(coordinate(path.at_target[0].point, 0)), 0.05);
  }
}

// Two rods, one upon the other, each with a spring k at its foot. With the angles a, b from upright
// and s = P L / k equilibrium is b - a = s sin(b), 2 a - b = s sin(a).
class TwoRods : public ::testing::Test {
 protected:
  static constexpr double k = 100, length = 0.3;

  static Path traced(double load) {
    const Pose rod = Pose::translation({length, 0, 0});
    ChainBuilder chain("rods");
    chain.actuator("lower", Motion::rz, k).offset(rod);
    chain.actuator("upper", Motion::rz, k).offset(rod);
    PathTask task;
    task.platform_held = false;
    task.growing.force = {-load * k / length, 0, 0};
    PathOptions options;
    options.branches = true;
    return trace_quietly({"rods", {chain.build()}}, task, options);
  }
  // Number of solutions with |b| up to two turns, by the signs of what is left when a is
  // eliminated.
  static std::size_t solutions(double s) {
    constexpr int steps = 400001;
    const auto left = [s](double b) {
      const double a = b - s * std::sin(b);
      return 2 * a - b - s * std::sin(a);
    };
    std::size_t found = 0;
    for (int i = 0; i < steps; ++i) {
      const double at = 4 * pi * ((2.0 * i - steps) / steps), next = at + 8 * pi / steps;
      found += left(at) * left(next) < 0;
    }
    return found;
  }
};

TEST_F(TwoRods, HaveTheirTwoPitchforksAndFiveEquilibria) {
  const double load = 3;
  ASSERT_EQ(solutions(load), 5U);
  const Path path = traced(load);
  ASSERT_EQ(path.critical.size(), 2U);
  EXPECT_EQ(count(path, CriticalKind::bifurcation), 2U);
  EXPECT_NEAR(path.critical[0].point.parameter * load, (3 - std::sqrt(5.0)) / 2, 1e-8);
  EXPECT_NEAR(path.critical[1].point.parameter * load, (3 + std::sqrt(5.0)) / 2, 1e-7);
  EXPECT_EQ(path.branches.size(), 5U);
  EXPECT_EQ(path.at_target.size(), 5U);
  for (const TargetPoint& target : path.at_target) {
    const double a = coordinate(target.point, 0), b = a + coordinate(target.point, 1);
    EXPECT_NEAR(b - a, load * std::sin(b), 1e-8);
    EXPECT_NEAR(2 * a - b, load * std::sin(a), 1e-8);
  }
}

TEST_F(TwoRods, HaveThreeEquilibriaBetweenTheirCriticalLoads) {
  ASSERT_EQ(solutions(1.5), 3U);
  const Path path = traced(1.5);
  EXPECT_EQ(path.critical.size(), 1U);
  EXPECT_EQ(path.branches.size(), 3U);
  EXPECT_EQ(path.at_target.size(), 3U);
}

// Two bars with axial springs c between supports 2 b apart, the apex h above them and pushed down:
// P = 2 c (l0 / l - 1) y on the upright branch with l^2 = b^2 + y^2. It has limit points at
// l^3 = l0 b^2 and gives way sideways where l^3 = l0 y^2.
class Truss : public ::testing::Test {
 protected:
  static constexpr double b = 1, c = 1e5;

  static Chain truss(double h) {
    const double slope = std::atan2(h, b), l0 = std::hypot(b, h);
    ChainBuilder chain("truss");
    chain.passive("pin1", Motion::rz, slope).offset(Pose::translation({l0, 0, 0}));
    chain.passive("bar1", Motion::tx, c, 0, 0).node("apex");
    chain.passive("hinge", Motion::rz, -2 * slope).offset(Pose::translation({l0, 0, 0}));
    chain.passive("bar2", Motion::tx, c, 0, 0).passive("pin2", Motion::rz, slope);
    return chain.build();
  }
  static Path pushed(const Chain& chain, double push, bool branches) {
    PathTask task;
    task.growing.nodes = {{0, chain.node_index("apex"), {0, -push, 0}}};
    PathOptions options;
    options.branches = branches;
    return trace_quietly({"truss", {chain}}, task, options);
  }
  static double height(const PathPoint& point, double h) {
    return (std::hypot(b, h) + coordinate(point, 1)) * std::sin(coordinate(point, 0));
  }
  static double load(double y, double h) {
    return 2 * c * (std::hypot(b, h) / std::hypot(b, y) - 1) * y;
  }
};

TEST_F(Truss, AShallowOneHasTwoLimitPointsAndNoOtherBranch) {
  const double h = 0.2, l = std::cbrt(std::hypot(b, h) * b * b), y = std::sqrt(l * l - b * b);
  const double push = 2 * load(y, h);
  const Path path = pushed(truss(h), push, true);
  EXPECT_EQ(path.branches.size(), 1U);
  EXPECT_EQ(path.branches[0].end, BranchEnd::target);
  ASSERT_EQ(path.critical.size(), 2U);
  EXPECT_EQ(count(path, CriticalKind::limit_point), 2U);
  EXPECT_NEAR(path.critical[0].point.parameter * push, load(y, h), 1e-8 * push);
  EXPECT_NEAR(path.critical[1].point.parameter * push, -load(y, h), 1e-8 * push);
}

// A load below the limit load meets three equilibria, two of them stable.
TEST_F(Truss, AShallowOneHasThreeEquilibriaUnderOneLoad) {
  const double h = 0.2, l = std::cbrt(std::hypot(b, h) * b * b), y = std::sqrt(l * l - b * b);
  const double push = 0.6 * load(y, h);
  PathTask task;
  const Chain chain = truss(h);
  task.growing.nodes = {{0, chain.node_index("apex"), {0, -push, 0}}};
  PathOptions options;
  options.highest = 2;
  options.lowest = -2;
  const Path path = trace_quietly({"truss", {chain}}, task, options);
  ASSERT_EQ(path.at_target.size(), 3U);
  for (const TargetPoint& target : path.at_target)
    EXPECT_NEAR(load(height(target.point, h), h), push, 1e-8 * push);
  EXPECT_TRUE(path.at_target[1].point.equilibrium.held.stable());
  EXPECT_FALSE(path.at_target[2].point.equilibrium.held.stable());
}

// Pushed down, then sideways: what the upright branch of a high truss passes, in closed form. Its
// sides swing around the supports.
TEST_F(Truss, AHighOneGivesWaySidewaysBeforeItsLimitPoint) {
  const double h = 3, l0 = std::hypot(b, h), push = 3 * c;
  const Path path = pushed(truss(h), push, true);
  std::vector<double> sideways, limits;
  for (const CriticalPoint& critical : path.critical) {
    ASSERT_NE(critical.kind, CriticalKind::contact) << "there is no stop";
    if (critical.branch != 0) continue;
    const double y = height(critical.point, h), l = std::hypot(b, y);
    EXPECT_NEAR(critical.point.parameter * push, load(y, h), 1e-8 * push);
    if (critical.kind == CriticalKind::bifurcation) {
      EXPECT_NEAR(l * l * l, l0 * y * y, 1e-6);
      sideways.push_back(y);
    } else {
      EXPECT_NEAR(l * l * l, l0 * b * b, 1e-6);
      limits.push_back(y);
    }
  }
  EXPECT_EQ(sideways.size(), 4U);
  EXPECT_EQ(limits.size(), 2U);
  for (const Branch& branch : path.branches) EXPECT_NE(branch.end, BranchEnd::limit);
  EXPECT_EQ(path.not_tried, 0U);
}

// The same truss with a stop that its first pin meets between the limit points.
TEST_F(Truss, AStopThatCatchesItIsAContact) {
  const double h = 0.2, l = std::cbrt(std::hypot(b, h) * b * b), y = std::sqrt(l * l - b * b);
  const double caught = 0.3 * y;
  ChainBuilder chain(truss(h));
  chain.law("pin1", std::make_shared<StopLaw>(std::atan2(caught, b), 1e9, 0.1 * c));
  const Path path = pushed(chain.build(), 2 * load(y, h), false);
  ASSERT_EQ(path.critical.size(), 2U);
  EXPECT_EQ(path.critical[0].kind, CriticalKind::limit_point);
  EXPECT_EQ(path.critical[1].kind, CriticalKind::contact);
  EXPECT_NEAR(height(path.critical[1].point, h), caught, 1e-6);
  EXPECT_EQ(path.critical[1].unstable_after, 0);
}

// Three links and two sprung joints held on a line (MMT11 section 6.1), pushed until the end has
// passed the base: bifurcations and limit points only, nothing twice.
TEST(Branches, TheShortenedChainHasNoContactsAndNoBranchTwice) {
  constexpr double length = 0.3, k = 100;
  const Pose link = Pose::translation({length, 0, 0});
  ChainBuilder chain("chain");
  chain.passive("u", Motion::rz).offset(link).actuator("a1", Motion::rz, k).offset(link);
  chain.actuator("a2", Motion::rz, k).offset(link).passive("s", Motion::rz);
  for (const double shortening : {0.9, 1.9, 2.9, 3.5}) {
    SCOPED_TRACE(shortening);
    PathTask task;
    task.displacement = -shortening * length * Vector6::Unit(0);
    PathOptions options;
    options.branches = true;
    const Path path = trace_quietly({"chain", {chain.build()}}, task, options);
    EXPECT_EQ(count(path, CriticalKind::contact), 0U);
    EXPECT_EQ(count(path, BranchEnd::joined), 0U);
    EXPECT_EQ(count(path, BranchEnd::limit), 0U);
    EXPECT_EQ(path.not_tried, 0U);
    // Where the end meets the base, the bent chain turns about it: two loops.
    EXPECT_EQ(count(path, BranchEnd::closed), shortening > 3 ? 2U : 0U);
    for (std::size_t i = 0; i < path.at_target.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        double apart = 0;
        for (Eigen::Index q = 0; q < 4; ++q)
          apart += std::abs(std::sin(
              (coordinate(path.at_target[i].point, q) - coordinate(path.at_target[j].point, q)) /
              2));
        EXPECT_GT(apart, 1e-6);
      }
    for (std::size_t i = 0; i < path.critical.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        double apart = (path.critical[i].point.equilibrium.wrench.force -
                        path.critical[j].point.equilibrium.wrench.force)
                           .norm();
        for (Eigen::Index q = 0; q < 4; ++q)
          apart += std::abs(std::sin(
              (coordinate(path.critical[i].point, q) - coordinate(path.critical[j].point, q)) / 2));
        EXPECT_GT(apart, 1e-6) << i << " and " << j;
      }
  }
}

}  // namespace
}  // namespace kinetostat::vjm::path_branches_test
