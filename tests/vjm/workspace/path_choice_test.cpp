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
  return best_path(manipulator, targets, index, turn, placements, 2, silent);
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
  EXPECT_THROW(best_path(slide, {}, along_x, std::nullopt, {Pose()}, 1, silent),
               std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::path_choice_test
