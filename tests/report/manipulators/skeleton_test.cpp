#include "kinetostat/report/manipulators/skeleton.h"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::report::skeleton_test {
namespace {

using io::Json;
using spatial::Vector3;

Vector3 vector(const Json& json) {
  return Vector3(json[0].get<double>(), json[1].get<double>(), json[2].get<double>());
}

class Skeleton : public ::testing::Test {
 protected:
  const vjm::Robot robot =
      vjm::read_robot(std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data/robots/orthoglide.yaml");
  const spatial::Pose place = spatial::Pose::translation({0.03, -0.02, 0.04});
  const vjm::Posture posture = posture_at(robot.manipulator, place).posture;
};

TEST_F(Skeleton, ChainsRunFromTheirBaseToThePlatform) {
  const Json json = skeleton(robot.manipulator, posture);
  ASSERT_EQ(json["chains"].size(), 3u);
  for (std::size_t c = 0; c < 3; ++c) {
    const Json& points = json["chains"][c]["points"];
    EXPECT_LT((vector(points.front()) - robot.manipulator.chains()[c].base().position()).norm(),
              1e-12);
    EXPECT_LT((vector(points.back()) - place.position()).norm(), 1e-9);
  }
  EXPECT_LT((vector(json["bodies"][0]["position"]) - place.position()).norm(), 1e-12);
}

// Foot 154.9 mm, leg 310 mm, tool 30 mm; actuator along axis i of the base.
TEST_F(Skeleton, LinksHaveTheirLengthsAndActuatorsTheirAxes) {
  const Json json = skeleton(robot.manipulator, posture);
  for (std::size_t c = 0; c < 3; ++c) {
    const Json& points = json["chains"][c]["points"];
    ASSERT_EQ(points.size(), 5u);  // base, carriage, foot's end, leg's end, tool
    const double lengths[] = {0.1549, 0.310, 0.030};
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR((vector(points[k + 2]) - vector(points[k + 1])).norm(), lengths[k], 1e-9);
    const Json& actuator = json["chains"][c]["joints"][0];
    EXPECT_EQ(actuator["role"], "actuated");
    EXPECT_FALSE(actuator["turns"].get<bool>());
    EXPECT_NEAR(vector(actuator["axis"])[static_cast<Eigen::Index>(c)], 1, 1e-12);
  }
}

TEST_F(Skeleton, FollowsTheEquilibrium) {
  vjm::Load load;
  load.force = {100, 0, 50};
  const vjm::Equilibrium loaded = equilibrium_under_load(robot.manipulator, posture, load);
  const Json json = skeleton(robot.manipulator, loaded);
  const Json lines = chain_lines(robot.manipulator, loaded);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_LT((vector(json["chains"][c]["points"].back()) - loaded.platform.position()).norm(),
              1e-9);
    EXPECT_LT((vector(lines[c].back()) - loaded.platform.position()).norm(), 1e-6);
  }
}

// Every shipped robot: each chain has as many points bent as unbent, some of them move, and the
// last goes as far as the platform.
TEST(SkeletonOfShippedRobots, EveryChainBends) {
  const std::filesystem::path folder = std::filesystem::path(KINETOSTAT_SOURCE_DIR) / "data/robots";
  std::size_t robots = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    const vjm::Robot robot = vjm::read_robot(entry.path());
    const vjm::Posture posture = vjm::posture_from_joints(robot.manipulator, {}).posture;
    vjm::Load load;
    load.force = {3, -4, -10};
    const vjm::Equilibrium bent = equilibrium_under_load(robot.manipulator, posture, load);
    if (bent.status != vjm::EquilibriumStatus::converged) continue;  // it folds at home
    const Json from = skeleton(robot.manipulator.without_errors(), posture);
    const Json to = skeleton(robot.manipulator, bent);
    for (std::size_t c = 0; c < robot.manipulator.size(); ++c) {
      const Json &a = from["chains"][c]["points"], &b = to["chains"][c]["points"];
      ASSERT_EQ(a.size(), b.size()) << entry.path() << " chain " << c;
      double largest = 0;
      for (std::size_t k = 0; k < a.size(); ++k)
        largest = std::max(largest, (vector(a[k]) - vector(b[k])).norm());
      const double shift = (vector(a.back()) - vector(b.back())).norm();
      EXPECT_GT(largest, 0) << entry.path() << " chain " << c;
      if (robot.manipulator.size() == 1) {
        EXPECT_NEAR(shift, (bent.platform.position() - posture.platform.position()).norm(), 1e-12);
      }
    }
    ++robots;
  }
  EXPECT_GE(robots, 3u);
}

// A straight link is one line to where its end has gone; nothing of it stays where it was.
TEST(SkeletonOfABeam, IsOneLineToItsDeflectedEnd) {
  const spatial::Matrix6 compliance = 1e-6 * spatial::Matrix6::Identity();
  vjm::ChainBuilder chain("arm");
  chain.actuator("q", vjm::Motion::rz, 1e4)
      .link("beam", spatial::Pose::translation({0.5, 0, 0}), spatial::Compliance6(compliance, {}));
  const vjm::Manipulator arm("arm", {chain.build()});
  const vjm::Posture posture = vjm::posture_from_joints(arm, {}).posture;
  vjm::Load load;
  load.force = {0, 0, -100};
  const Json points =
      skeleton(arm, equilibrium_under_load(arm, posture, load))["chains"][0]["points"];
  ASSERT_EQ(points.size(), 3u);  // base, the beam's end, the chain's
  EXPECT_LT(vector(points[1])[2], -5e-5);
}

// What a screw slides along is drawn as a slide, though a turn drives it.
TEST(SkeletonOfAScrew, ShowsEachJointAsItMoves) {
  vjm::ChainBuilder chain("arm");
  chain.actuator("motor", vjm::Motion::rz, 1e4).coupled("motor", vjm::Motion::tx, 0.01);
  const vjm::Manipulator screw("screw", {chain.build()});
  const Json joints =
      skeleton(screw, vjm::posture_from_joints(screw, {}).posture)["chains"][0]["joints"];
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_TRUE(joints[0]["turns"].get<bool>());
  EXPECT_FALSE(joints[1]["turns"].get<bool>());
  EXPECT_LT((vector(joints[1]["axis"]) - Vector3::UnitX()).norm(), 1e-15);
}

}  // namespace
}  // namespace kinetostat::report::skeleton_test
