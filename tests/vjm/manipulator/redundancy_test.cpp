#include "kinetostat/vjm/manipulator/redundancy.h"

#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::redundancy_test {
namespace {

using spatial::Pose;
using ::testing::ElementsAre;

Manipulator shipped(const std::string& name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name).manipulator;
}

// The elbow alone decides how far the wrist is from the shoulder: it is the one that cannot move.
TEST(Redundancy, OfSevenJointsIsOfAllButTheElbow) {
  const Manipulator arm = shipped("seven_axis.yaml");
  const Pose target =
      posture_from_joints(arm, {{"a1", 0.2}, {"a2", 0.5}, {"a3", 0.3}, {"a4", 1.4}, {"a6", 1.2}})
          .posture.platform;
  EXPECT_THAT(redundant_joints(arm, target, {}),
              ElementsAre("arm.a1", "arm.a2", "arm.a3", "arm.a5", "arm.a6", "arm.a7"));
  // One joint held where it stands takes it away from the others.
  const double a1 = posture_at(arm, target).posture.coordinates[0][0];
  EXPECT_FALSE(may_move_at(arm, target, {{"arm.a1", a1}}, "a3"));
  EXPECT_THROW(may_move_at(arm, target, {}, "a9"), std::invalid_argument);
}

TEST(Redundancy, OfSixJointsIsNone) {
  const Manipulator arm = shipped("six_axis.yaml");
  const Pose target =
      posture_from_joints(arm, {{"q2", -0.3}, {"q3", 0.7}, {"q5", 0.5}}).posture.platform;
  EXPECT_TRUE(redundant_joints(arm, target, {}).empty());
  EXPECT_FALSE(may_move_at(arm, Pose::translation({9, 9, 9}), {}, "q1"));
}

// With axes four and six in line only their sum counts.
TEST(Redundancy, IsOfAWristInLine) {
  const Manipulator arm = shipped("six_axis.yaml");
  const Pose target =
      posture_from_joints(arm, {{"q2", -0.3}, {"q3", 0.3}, {"q5", 0}}).posture.platform;
  EXPECT_THAT(redundant_joints(arm, target, {}), ElementsAre("arm.q4", "arm.q6"));
}

// A stretched arm has a null vector and no motion.
TEST(Redundancy, IsNotSingularity) {
  ChainBuilder chain("arm");
  chain.actuator("q1", Motion::rz, 1e4).offset(Pose::translation({0.5, 0, 0}));
  chain.actuator("q2", Motion::rz, 1e4).offset(Pose::translation({0.5, 0, 0}));
  chain.passive("q3", Motion::rz);
  const Manipulator arm("stretched", {chain.build()});
  EXPECT_TRUE(redundant_joints(arm, Pose::translation({1, 0, 0}), {}).empty());
}

}  // namespace
}  // namespace kinetostat::vjm::redundancy_test
