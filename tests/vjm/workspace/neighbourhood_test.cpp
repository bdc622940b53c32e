#include "kinetostat/vjm/workspace/neighbourhood.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::neighbourhood_test {
namespace {

const std::filesystem::path data = std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data";

struct About {
  explicit About(const std::filesystem::path& file, double distance = 0.02)
      : robot(read_robot(data / file)),
        home(posture_from_joints(robot.manipulator, {}).posture),
        found(neighbourhood(robot.manipulator, home, distance)) {}
  double farthest() const {
    double most = 0;
    for (const TargetPose& target : found.list.poses)
      most = std::max(most, (target.platform.position() - home.platform.position()).norm());
    return most;
  }

  Robot robot;
  Posture home;
  Neighbourhood found;
};

TEST(Neighbourhood, KeepsTheOrientationWhereItCanBeHeld) {
  for (const char* file : {"robots/orthoglide.yaml", "robots/six_axis.yaml"}) {
    const About about(file);
    EXPECT_TRUE(about.found.joints.empty()) << file;
    ASSERT_EQ(about.found.list.poses.size(), 27u);
    EXPECT_NEAR(about.farthest(), 0.02 * std::sqrt(3), 1e-12);
    for (const TargetPose& target : about.found.list.poses)
      EXPECT_TRUE(target.platform.rotation().isApprox(about.home.platform.rotation(), 1e-12));
  }
}

TEST(Neighbourhood, MovesTheJointsOfAnArmOfThree) {
  const About about("measurements/arm_hysteresis/robot.yaml");
  EXPECT_EQ(about.found.joints, (std::vector<std::string>{"arm.q1", "arm.q2", "arm.q3"}));
  ASSERT_EQ(about.found.list.poses.size(), 27u);
  // One joint takes it as far as asked for, all three together no further than three times that.
  EXPECT_GT(about.farthest(), 0.019);
  EXPECT_LT(about.farthest(), 0.06);
}

TEST(Neighbourhood, IsReachedByEveryShippedRobotThatStandsAtHome) {
  int robots = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data / "robots")) {
    const Robot robot = read_robot(entry.path());
    const PostureResult home = posture_from_joints(robot.manipulator, {});
    if (!home.reached) continue;
    ++robots;
    const Neighbourhood about = neighbourhood(robot.manipulator, home.posture, 0.01);
    for (const TargetPose& target : about.list.poses)
      EXPECT_TRUE(posture_at(robot.manipulator, target.platform).reached) << entry.path();
  }
  EXPECT_GE(robots, 10);
}

}  // namespace
}  // namespace kinetostat::vjm::neighbourhood_test
