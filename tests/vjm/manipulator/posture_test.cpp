#include "kinetostat/vjm/manipulator/posture.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/io/robot_file.h"

#include "vjm/random_chain.h"

namespace kinetostat::vjm::posture_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using ::testing::HasSubstr;

// Offsets of a common industrial 6R layout.
Manipulator six_axis_arm() {
  ChainBuilder chain("arm");
  const Motion axes[] = {Motion::rz, Motion::ry, Motion::ry, Motion::rx, Motion::ry, Motion::rx};
  const Vector3 offsets[] = {{0.15, 0, 0.45}, {0, 0, 0.6}, {0.2, 0, 0.12},
                             {0.44, 0, 0},    {0.1, 0, 0}, {0.05, 0, 0}};
  for (int i = 0; i < 6; ++i)
    chain.actuator("q" + std::to_string(i + 1), axes[i], 1e5).offset(Pose::translation(offsets[i]));
  return Manipulator("6R", {chain.build()});
}

TEST(PostureAt, ReachesWhateverForwardKinematicsReached) {
  samples::RandomChains random(21);
  const Manipulator arm = six_axis_arm();
  const Chain& chain = arm.chains()[0];
  ChainKinematics kinematics;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::VectorXd x = random.state(chain, 2.0);
    evaluate(chain, x, kinematics);
    const PostureResult result = posture_at(arm, kinematics.end);
    ASSERT_TRUE(result.reached) << "trial " << trial << ": " << result.reason;
    evaluate(chain, result.posture.coordinates[0], kinematics);
    EXPECT_LT(spatial::pose_difference(kinematics.end, result.posture.platform).norm(), 1e-11);
  }
}

TEST(PostureAt, TakesTheBranchNearestToHome) {
  ChainBuilder chain("scara");
  chain.actuator("q1", Motion::rz, 1e4, 0.5).offset(Pose::translation({0.5, 0, 0}));
  chain.actuator("q2", Motion::rz, 1e4, -1.0).offset(Pose::translation({0.5, 0, 0}));
  chain.passive("q3", Motion::rz);
  const Manipulator scara("scara", {chain.build()});
  const PostureResult result = posture_at(scara, Pose::translation({0.6, 0.1, 0}));
  ASSERT_TRUE(result.reached) << result.reason;
  EXPECT_LT(result.posture.coordinates[0][1], 0);  // elbow as at home
}

TEST(PostureAt, SaysHowFarAnUnreachablePoseIs) {
  const PostureResult result = posture_at(six_axis_arm(), Pose::translation({5, 0, 0}));
  EXPECT_FALSE(result.reached);
  EXPECT_THAT(result.reason, HasSubstr("chain 'arm' cannot reach the pose"));
  EXPECT_GT(result.error.head<3>().norm(), 3.0);
}

TEST(PostureAt, ARedundantArmStaysNearItsHome) {
  ChainBuilder chain("7R");
  const Motion axes[] = {Motion::rz, Motion::ry, Motion::rz, Motion::ry,
                         Motion::rz, Motion::ry, Motion::rz};
  for (int i = 0; i < 7; ++i)
    chain.actuator("q" + std::to_string(i), axes[i], 1e4, 0.3)
        .offset(Pose::translation({0, 0, 0.2}));
  const Manipulator arm("7R", {chain.build()});
  ChainKinematics kinematics;
  evaluate(arm.chains()[0], arm.chains()[0].home(), kinematics);
  const PostureResult result = posture_at(arm, kinematics.end);
  ASSERT_TRUE(result.reached);
  EXPECT_LT((result.posture.coordinates[0] - arm.chains()[0].home()).norm(), 1e-9);
}

TEST(PostureFromJoints, ClosesTheLoopsOfAParallelRobot) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  const Vector3 point(0.05, -0.02, 0.03);
  const PostureResult there = posture_at(robot.manipulator, Pose::translation(point));
  ASSERT_TRUE(there.reached);
  std::map<std::string, double> joints;
  for (std::size_t c = 0; c < 3; ++c)
    joints[robot.manipulator.chains()[c].name() + ".rho"] = there.posture.coordinates[c][0];
  const PostureResult back = posture_from_joints(robot.manipulator, joints);
  ASSERT_TRUE(back.reached) << back.reason;
  EXPECT_LT((back.posture.platform.position() - point).norm(), 1e-9);
}

TEST(PostureFromJoints, SaysWhenLoopsCannotBeClosed) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  const PostureResult result = posture_from_joints(robot.manipulator, {{"x.rho", -3.0}});
  EXPECT_FALSE(result.reached);
  EXPECT_THAT(result.reason, HasSubstr("loops cannot be closed"));
}

TEST(PostureFromJoints, UnknownAndAmbiguousNamesAreRefused) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  try {
    posture_from_joints(robot.manipulator, {{"x.roh", 0.0}});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'x.rho'?"));
  }
  EXPECT_THROW(posture_from_joints(robot.manipulator, {{"rho", 0.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::posture_test
