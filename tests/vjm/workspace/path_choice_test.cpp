#include "kinetostat/vjm/workspace/path_choice.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::path_choice_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using Kind = MapIndex::Kind;

constexpr double quarter = std::numbers::pi / 2;
const MapIndex along_x{.kind = Kind::stiffness, .direction = Vector3::UnitX()};

PathChoice best(const Manipulator& manipulator, const std::vector<TargetPose>& targets,
                const MapIndex& index, const std::optional<FreeTurn>& turn,
                const std::vector<Pose>& placements = {Pose()}) {
  common::Progress silent;
  return best_path(manipulator, targets, index, {.turn = turn, .placements = placements}, 2,
                   silent);
}

// Slides that carry the tool on a wrist before them: turned by a quarter they are twice as stiff.
Manipulator slides_on_a_wrist() {
  ChainBuilder chain("slides");
  chain.actuator("a", Motion::tx, std::nullopt).actuator("b", Motion::ty, std::nullopt);
  chain.actuator("c", Motion::rz, std::nullopt);
  chain.actuator("x", Motion::tx, 1e6).actuator("y", Motion::ty, 2e6);
  chain.actuator("z", Motion::tz, 4e6);
  return {"slides on a wrist", {chain.build()}};
}

TEST(PathChoice, TurnsTheStiffSlideIntoTheDirection) {
  const std::vector<TargetPose> path{{Pose()}, {Pose::translation({0.1, 0, 0})}};
  const FreeTurn turn{.from = -quarter, .to = quarter, .steps = 19};
  const PathChoice choice = best(slides_on_a_wrist(), path, along_x, turn);
  EXPECT_NEAR(choice.worst, 2e6, 1e-3);
  for (const double angle : choice.turns) EXPECT_NEAR(std::abs(angle), quarter, 1e-12);
  // Half of the way: cos^2/kx + sin^2/ky.
  const FreeTurn half{.from = 0, .to = quarter / 2, .steps = 5};
  EXPECT_NEAR(best(slides_on_a_wrist(), path, along_x, half).worst, 1 / (0.5 / 1e6 + 0.5 / 2e6),
              1e-3);
}

// The wrist behind the slides: where the base stands decides.
TEST(PathChoice, PlacesTheBaseSoThatTheStiffSlideDoesTheWork) {
  ChainBuilder chain("slides");
  chain.actuator("x", Motion::tx, 1e6).actuator("y", Motion::ty, 2e6);
  chain.actuator("c", Motion::rz, std::nullopt);
  const Manipulator slides{"slides", {chain.build()}};
  std::vector<Pose> placements;
  for (const double angle : {0., quarter / 2, quarter})
    placements.emplace_back(spatial::exp_rotation(angle * Vector3::UnitZ()), Vector3(0.2, 0, 0));
  const std::vector<TargetPose> path{{Pose()}, {Pose::translation({0, 0.3, 0})}};
  const PathChoice choice = best(slides, path, along_x, std::nullopt, placements);
  EXPECT_EQ(choice.placement, 2u);
  EXPECT_NEAR(choice.worst, 2e6, 1e-3);
  EXPECT_TRUE(choice.turns.empty());
}

// Everything that follows the rule of neighbours, tried one by one.
TEST(PathChoice, IsTheBestOfAllWays) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/six_axis.yaml");
  const Pose home = posture_from_joints(robot.manipulator, {}).posture.platform;
  std::vector<TargetPose> path;
  for (int i = 0; i < 4; ++i)
    path.push_back({Pose(home.rotation(), home.position() + Vector3(0.1 * i, -0.2 * i, 0.15 * i)),
                    {.force = {0, 0, -500}}});
  for (const Kind kind : {Kind::weakest_translation, Kind::deflection}) {
    const MapIndex index{.kind = kind};
    const FreeTurn turn{
        .axis = Vector3::UnitX(), .from = -1, .to = 1, .steps = 5, .largest_change = 0.5};
    const PathChoice choice = best(robot.manipulator, path, index, turn);
    std::vector<std::vector<double>> scores(path.size());
    const auto angle_of = [](int k) { return -1 + 0.5 * k; };
    for (std::size_t i = 0; i < path.size(); ++i)
      for (int k = 0; k < 5; ++k) {
        const double value =
            map_point(robot.manipulator, turned(path[i], Vector3::UnitX(), angle_of(k)), {index})
                .values[0];
        scores[i].push_back((is_more_better(kind) ? 1 : -1) * std::log(value));
      }
    double worst = -1e300, sum = -1e300;
    std::vector<int> way;
    for (int n = 0; n < 625; ++n) {
      const std::vector<int> k{n % 5, n / 5 % 5, n / 25 % 5, n / 125};
      double least = 1e300, total = 0;
      bool follows = true;
      for (std::size_t i = 0; i < 4; ++i) {
        least = std::min(least, scores[i][static_cast<std::size_t>(k[i])]);
        total += scores[i][static_cast<std::size_t>(k[i])];
        follows &= i == 0 || std::abs(k[i] - k[i - 1]) <= 1;
      }
      const bool is_as_good = std::abs(least - worst) < 1e-9;
      if (!follows || (!is_as_good && least < worst) || (is_as_good && total <= sum)) continue;
      worst = least, sum = total, way = k;
    }
    EXPECT_NEAR((is_more_better(kind) ? 1 : -1) * std::log(choice.worst), worst, 1e-9);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(choice.turns[i], angle_of(way[i]), 1e-12) << i;
  }
}

// The point where the load acts stays where it is, and so does the load.
TEST(PathChoice, MovesNothingOfTheWork) {
  const TargetPose pose{
      Pose(spatial::exp_rotation({0.3, -0.2, 0.5}), {0.1, 0.2, 0.3}),
      {.force = {1, 2, 3}, .moment = {4, 5, 6}, .point_on_platform = {0.1, 0, 0.2}}};
  const TargetPose spun = turned(pose, Vector3::UnitY(), 0.7);
  EXPECT_LT(
      (spun.platform * spun.load.point_on_platform - pose.platform * pose.load.point_on_platform)
          .norm(),
      1e-15);
  EXPECT_EQ(spun.platform.position(), pose.platform.position());
  EXPECT_LT(
      (spun.platform.rotation() * Vector3::UnitY() - pose.platform.rotation() * Vector3::UnitY())
          .norm(),
      1e-15);
  const Pose base(spatial::exp_rotation({0, 0, 0.4}), {1, 2, 0});
  const TargetPose seen = seen_from(pose, base);
  EXPECT_LT((base * seen.platform.position() - pose.platform.position()).norm(), 1e-15);
  EXPECT_LT((base.rotation() * seen.load.force - pose.load.force).norm(), 1e-15);
}

// What can be reached is turned all the same.
TEST(PathChoice, MakesTheBestOfAPathThatIsNotReachedThroughout) {
  const std::vector<TargetPose> path{
      {Pose()}, {Pose(spatial::exp_rotation({1, 0, 0}), Vector3::Zero())}, {Pose()}};
  const FreeTurn turn{.from = -quarter, .to = quarter, .steps = 19};
  const PathChoice choice = best(slides_on_a_wrist(), path, along_x, turn);
  EXPECT_TRUE(std::isnan(choice.worst));
  for (const std::size_t reached : {0, 2})
    EXPECT_NEAR(std::abs(choice.turns[reached]), quarter, 1e-12);
}

// Out of reach whatever is done.
TEST(PathChoice, SaysWhereNothingHelps) {
  ChainBuilder chain("slide");
  chain.actuator("x", Motion::tx, 1e6);
  const Manipulator slide{"slide", {chain.build()}};
  const PathChoice choice = best(slide, {{Pose::translation({0, 1, 0})}}, along_x, std::nullopt);
  EXPECT_TRUE(std::isnan(choice.worst));
  EXPECT_EQ(choice.poses.size(), 1u);
  common::Progress silent;
  EXPECT_THROW(best_path(slide, {}, along_x, {}, 1, silent), std::invalid_argument);
}

// Three joints in the plane and a spindle at the tool, which turns with nothing to say: the pose
// leaves one joint free. Beside it what a draughtsman computes for a held first joint: the two
// others by the law of cosines, elbow down as at home, and d/F = sum of lever^2 / k.
struct PlanarArm {
  static constexpr double l1 = 0.5, l2 = 0.45, l3 = 0.35, k1 = 2e4, k2 = 1.2e4, k3 = 8e3;

  static Manipulator manipulator() {
    ChainBuilder chain("arm");
    chain.actuator("q1", Motion::rz, k1, 0.9).offset(Pose::translation({l1, 0, 0}));
    chain.actuator("q2", Motion::rz, k2, -0.6).offset(Pose::translation({l2, 0, 0}));
    chain.actuator("q3", Motion::rz, k3, -0.9).offset(Pose::translation({l3, 0, 0}));
    chain.actuator("spindle", Motion::rz, std::nullopt);
    return {"planar arm", {chain.build()}};
  }

  // Force over displacement along x at (x, y); NaN where the two links do not reach.
  static double stiffness_along_x(double x, double y, double q1) {
    const double px = x - l1 * std::cos(q1), py = y - l1 * std::sin(q1);
    const double cosine = (px * px + py * py - l2 * l2 - l3 * l3) / (2 * l2 * l3);
    if (std::abs(cosine) > 1) return std::numeric_limits<double>::quiet_NaN();
    const double q3 = -std::acos(cosine);
    const double along = std::atan2(py, px) - std::atan2(l3 * std::sin(q3), l2 + l3 * std::cos(q3));
    const double elbow = py - l2 * std::sin(along);  // lever of the third joint
    return 1 / (y * y / k1 + py * py / k2 + elbow * elbow / k3);
  }
};

std::vector<TargetPose> planar_path() {
  std::vector<TargetPose> path;
  for (int i = 0; i < 4; ++i)
    path.push_back({Pose::translation({0.65 + 0.04 * i, 0.45 - 0.08 * i, 0})});
  return path;
}

// The best of all ways on a grid and through the values given, tried one by one.
struct BruteForce {
  double largest_change = 0;
  std::vector<std::vector<double>> values = {}, stiffness = {};  // pose by pose
  double worst = 0, sum = -1e300;
  std::vector<double> way = {};

  void run(std::vector<std::size_t> taken = {}) {
    const std::size_t i = taken.size();
    if (i == values.size()) return judge(taken);
    for (std::size_t k = 0; k < values[i].size(); ++k) {
      if (std::isnan(stiffness[i][k])) continue;
      if (i > 0 && std::abs(values[i][k] - values[i - 1][taken[i - 1]]) > largest_change + 1e-9)
        continue;
      std::vector<std::size_t> longer = taken;
      longer.push_back(k);
      run(longer);
    }
  }

  void judge(const std::vector<std::size_t>& taken) {
    double least = 1e300, total = 0;
    std::vector<double> joint;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      least = std::min(least, stiffness[i][taken[i]]);
      total += std::log(stiffness[i][taken[i]]);
      joint.push_back(values[i][taken[i]]);
    }
    const bool is_as_good = std::abs(least - worst) < 1e-7 * worst;
    if (!is_as_good && least < worst) return;
    if (is_as_good && total <= sum) return;
    worst = least, sum = total, way = joint;
  }
};

// All ways of the first joint along a path that its values on a grid make, and the value that it
// has without being held where the grid reaches as far.
BruteForce ways_of_planar_arm(const std::vector<TargetPose>& path, const FreeJoint& joint) {
  BruteForce all{.largest_change = joint.largest_change};
  for (const TargetPose& pose : path) {
    std::vector<double> values, stiffness;
    for (int k = 0; k < joint.steps; ++k)
      values.push_back(joint.from + (joint.to - joint.from) * k / (joint.steps - 1));
    const double given =
        posture_at(PlanarArm::manipulator(), pose.platform).posture.coordinates[0][0];
    if (given >= joint.from && given <= joint.to) values.push_back(given);
    for (const double q1 : values)
      stiffness.push_back(PlanarArm::stiffness_along_x(pose.platform.position().x(),
                                                       pose.platform.position().y(), q1));
    all.values.push_back(values);
    all.stiffness.push_back(stiffness);
  }
  all.run();
  return all;
}

TEST(PathChoice, HoldsTheJointThatMakesAPlanarArmStiffest) {
  const Manipulator arm = PlanarArm::manipulator();
  const std::vector<TargetPose> path = planar_path();
  common::Progress silent;
  // Where the joint stands at the first pose when nothing holds it is in the second range alone.
  for (const auto& [to, steps] : {std::pair(1.4, 10), std::pair(1.8, 12)})
    for (const double change : {std::numeric_limits<double>::infinity(), 0.21}) {
      const FreeJoint joint{
          .name = "arm.q1", .from = -0.4, .to = to, .steps = steps, .largest_change = change};
      const BruteForce all = ways_of_planar_arm(path, joint);
      ASSERT_EQ(all.values[0].size(), static_cast<std::size_t>(steps) + (to > 1.5 ? 1 : 0));
      const PathChoice choice = best_path(arm, path, along_x, {.joints = {joint}}, 2, silent);
      EXPECT_NEAR(choice.worst, all.worst, 1e-7 * all.worst);
      ASSERT_EQ(choice.joints.size(), 1u);
      ASSERT_EQ(all.way.size(), path.size());
      for (std::size_t i = 0; i < path.size(); ++i) {
        EXPECT_NEAR(choice.joints[0][i], all.way[i], 1e-9) << i;
        EXPECT_EQ(choice.poses[i].held.at("arm.q1"), choice.joints[0][i]);
      }
    }
}

// A value of the joint on the grid, and what the robot does with it: the closed form at each.
TEST(PathChoice, ValuesAreThoseOfTheHeldPosture) {
  const Manipulator arm = PlanarArm::manipulator();
  for (const TargetPose& pose : planar_path())
    for (int k = 0; k < 19; ++k) {
      TargetPose held = pose;
      held.held["q1"] = -0.4 + 0.1 * k;
      const double expected = PlanarArm::stiffness_along_x(
          pose.platform.position().x(), pose.platform.position().y(), -0.4 + 0.1 * k);
      const MapPoint point = map_point(arm, held, {along_x});
      if (std::isnan(expected))
        EXPECT_EQ(point.state, MapState::unreachable);
      else
        EXPECT_NEAR(point.values[0], expected, 1e-7 * expected) << k;
    }
}

double worst_of(const std::vector<MapPoint>& points) {
  double worst = std::numeric_limits<double>::infinity();
  for (const MapPoint& point : points) worst = std::min(worst, point.values[0]);
  return worst;
}

std::vector<TargetPose> seven_axis_path() {
  std::vector<TargetPose> path;
  for (int i = 0; i < 5; ++i)
    path.push_back({Pose(spatial::exp_rotation({0, 2.8, 0}), {0.5, -0.2 + 0.1 * i, 0.4})});
  return path;
}

Robot seven_axis() {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/seven_axis.yaml");
}

TEST(PathChoice, OfSevenJointsIsNeverWorseThanTheGivenAndKeepsTheLimits) {
  const Manipulator arm = seven_axis().manipulator;
  const std::vector<TargetPose> path = seven_axis_path();
  common::Progress silent;
  for (const Kind kind : {Kind::weakest_translation, Kind::stiffness}) {
    const MapIndex index{.kind = kind, .direction = Vector3::UnitZ()};
    const double given = worst_of(workspace_map(arm, path, {index}, 2, silent));
    // A grid of two values that helps nobody, and one that does.
    for (const int steps : {2, 13}) {
      const FreeJoint joint{.name = "arm.a1", .from = -2.5, .to = 2.5, .steps = steps};
      const PathChoice choice = best_path(arm, path, index, {.joints = {joint}}, 2, silent);
      EXPECT_GE(choice.worst, given * (1 - 1e-9)) << steps;
      if (steps == 13) {
        EXPECT_GT(choice.worst, 1.02 * given);
      }
      EXPECT_NEAR(worst_of(workspace_map(arm, choice.poses, {index}, 2, silent)), choice.worst,
                  1e-9 * choice.worst);
      for (const TargetPose& pose : choice.poses) {
        const PostureResult found = posture_holding(arm, pose.platform, pose.held);
        ASSERT_TRUE(found.reached);
        for (std::size_t k = 0; k < arm.chains()[0].coordinates().size(); ++k) {
          const Coordinate& coordinate = arm.chains()[0].coordinates()[k];
          if (!coordinate.range) continue;
          const double turned_back = std::remainder(
              found.posture.coordinates[0][static_cast<Eigen::Index>(k)], 2 * std::numbers::pi);
          EXPECT_GE(turned_back, (*coordinate.range)[0] - 1e-9) << coordinate.name;
          EXPECT_LE(turned_back, (*coordinate.range)[1] + 1e-9) << coordinate.name;
        }
      }
    }
  }
}

// All three at once: no worse than each alone, and each value among those that were tried.
TEST(PathChoice, TriesTurnJointAndPlacementTogether) {
  const Manipulator arm = seven_axis().manipulator;
  const std::vector<TargetPose> path = seven_axis_path();
  const MapIndex index{.kind = Kind::stiffness, .direction = Vector3::UnitZ()};
  const FreeTurn turn{.axis = Vector3::UnitZ(), .from = -1, .to = 1, .steps = 3};
  const FreeJoint joint{.name = "arm.a3", .from = -1.2, .to = 1.2, .steps = 5};
  const std::vector<Pose> placements{Pose(), Pose::translation({-0.1, 0, 0})};
  common::Progress silent;
  const auto worst = [&](const PathFreedom& freedom) {
    return best_path(arm, path, index, freedom, 2, silent).worst;
  };
  const PathFreedom all{.turn = turn, .joints = {joint}, .placements = placements};
  EXPECT_EQ(candidates_per_pose(all), 3 * (5 + 1));
  const double together = worst(all);
  for (const PathFreedom& alone :
       {PathFreedom{.turn = turn}, PathFreedom{.joints = {joint}},
        PathFreedom{.placements = placements}, PathFreedom{.turn = turn, .joints = {joint}}})
    EXPECT_GE(together, worst(alone) * (1 - 1e-9));
}

TEST(PathChoice, LargestTurnSaysWhichJointAndWhere) {
  ChainBuilder chain("arm");
  chain.actuator("q1", Motion::rz, 1e4, 0.5).offset(Pose::translation({0.5, 0, 0}));
  chain.actuator("q2", Motion::rz, 1e4, -1.0).offset(Pose::translation({0.5, 0, 0}));
  chain.passive("q3", Motion::rz);
  const Manipulator arm("two links", {chain.build()});
  // Straight ahead, the elbow to one side; then the same to the left.
  const std::vector<TargetPose> path{{Pose::translation({0.8, 0, 0})},
                                     {Pose::translation({0.79, 0, 0})},
                                     {Pose::translation({0, 0.79, 0})}};
  const JointStep step = largest_turn(arm, path);
  EXPECT_EQ(step.joint, "arm.q1");
  EXPECT_EQ(step.pose, 2u);
  EXPECT_NEAR(step.change, quarter, 1e-9);
  EXPECT_TRUE(largest_turn(arm, {path[0]}).joint.empty());
}

}  // namespace
}  // namespace kinetostat::vjm::path_choice_test
