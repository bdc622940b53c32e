#include "kinetostat/vjm/manipulator/posture.h"

#include <cmath>
#include <numbers>
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

// Three cranks whose rods turn about parallel axes at both ends: the platform keeps its
// orientation, wherever cranks are, and each rod its length.
TEST(PostureFromJoints, KeepsTheAssemblyOfHome) {
  const double deg = std::numbers::pi / 180;
  std::vector<Chain> arms;
  for (int i = 0; i < 3; ++i) {
    ChainBuilder arm(std::string(1, static_cast<char>('a' + i)),
                     Pose(spatial::exp_rotation({0, 0, 120 * i * deg}), Vector3::Zero()) *
                         Pose::translation({0.2, 0, 0}));
    arm.actuator("q", Motion::ry, 9000, 20 * deg).offset(Pose::translation({0.24, 0, 0}));
    arm.passive("u1y", Motion::ry, 90 * deg).passive("u1z", Motion::rz);
    arm.offset(Pose::translation({0.56, 0, 0}));
    arm.passive("u2z", Motion::rz).passive("u2y", Motion::ry, -110 * deg);
    arm.attach(Pose::translation({-0.13, 0, 0}) *
               Pose(spatial::exp_rotation({0, 0, -120 * i * deg}), Vector3::Zero()));
    arms.push_back(arm.build());
  }
  const Manipulator delta("delta", arms);
  for (int n = 0; n < 64; ++n) {
    const Vector3 q =
        deg * Vector3(-10 + 20 * (n % 4), -10 + 20 * (n / 4 % 4), -10 + 20 * (n / 16));
    const PostureResult found =
        posture_from_joints(delta, {{"a.q", q[0]}, {"b.q", q[1]}, {"c.q", q[2]}});
    ASSERT_TRUE(found.reached) << q.transpose() << ": " << found.reason;
    EXPECT_LT((found.posture.platform.rotation() - spatial::Matrix3::Identity()).norm(), 1e-8);
    for (int i = 0; i < 3; ++i) {
      const spatial::Matrix3 side = spatial::exp_rotation({0, 0, 120 * i * deg});
      const Vector3 elbow = side * Vector3(0.2 + 0.24 * std::cos(q[i]), 0, -0.24 * std::sin(q[i]));
      const Vector3 tip = found.posture.platform.position() + side * Vector3(0.13, 0, 0);
      EXPECT_NEAR((tip - elbow).norm(), 0.56, 1e-9);
    }
  }
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

// Shoulder and wrist of three crossing axes, an elbow between them.
Manipulator seven_axis_arm() {
  ChainBuilder chain("arm");
  const double home[] = {0, 0.5, 0, 1.4, 0, 1.2, 0};
  for (int i = 0; i < 7; ++i) {
    chain.actuator("a" + std::to_string(i + 1), i % 2 == 0 ? Motion::rz : Motion::ry, 1e4, home[i]);
    if (i == 1 || i == 3) chain.offset(Pose::translation({0, 0, 0.4}));
  }
  return Manipulator("7R", {chain.offset(Pose::translation({0, 0, 0.1})).build()});
}

const Pose reached_by_seven(spatial::exp_rotation({0, 2.9, 0.3}), {0.5, 0.1, 0.1});

// The elbow goes along its circle about the line from shoulder to wrist.
TEST(PostureHolding, LetsTheElbowSwivelAndKeepsThePose) {
  const Manipulator arm = seven_axis_arm();
  const Chain& chain = arm.chains()[0];
  const Posture unheld = posture_at(arm, reached_by_seven).posture;
  const Vector3 wrist = reached_by_seven * Vector3(0, 0, -0.1);
  Eigen::VectorXd before = unheld.coordinates[0];
  ChainKinematics kinematics;
  for (int degree = 1; degree <= 50; ++degree) {
    const double value = unheld.coordinates[0][0] + degree * M_PI / 180;
    const PostureResult result = posture_holding(arm, reached_by_seven, {{"arm.a1", value}});
    ASSERT_TRUE(result.reached) << degree << ": " << result.reason;
    const Eigen::VectorXd& x = result.posture.coordinates[0];
    EXPECT_EQ(x[0], value);
    evaluate(chain, x, kinematics);
    EXPECT_LT(spatial::pose_difference(kinematics.end, reached_by_seven).norm(), 1e-11);
    const Vector3 elbow = frame_behind(chain, x, 2) * Vector3(0, 0, 0.4);
    EXPECT_NEAR(elbow.norm(), 0.4, 1e-12);
    EXPECT_NEAR((elbow - wrist).norm(), 0.4, 1e-11);
    // Neighbours, not another of the postures.
    EXPECT_LT((x - before).lpNorm<Eigen::Infinity>(), 0.3) << degree;
    before = x;
  }
}

TEST(PostureHolding, KeepsWhatStandsThereAnyway) {
  const Manipulator arm = seven_axis_arm();
  const Posture unheld = posture_at(arm, reached_by_seven).posture;
  const PostureResult held =
      posture_holding(arm, reached_by_seven, {{"a3", unheld.coordinates[0][2]}});
  ASSERT_TRUE(held.reached);
  EXPECT_LT((held.posture.coordinates[0] - unheld.coordinates[0]).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(PostureHolding, DoesNotReachWhereThePoseLeavesNoFreedom) {
  const Manipulator arm = six_axis_arm();
  const Pose target =
      posture_from_joints(arm, {{"q2", 0.3}, {"q3", 0.4}, {"q5", 0.7}}).posture.platform;
  const PostureResult held = posture_holding(arm, target, {{"q1", 0.1}});
  EXPECT_FALSE(held.reached);
  EXPECT_THAT(held.reason, HasSubstr("cannot reach the pose"));
  EXPECT_THROW(posture_holding(arm, target, {{"q9", 0.1}}), std::invalid_argument);
}

// A carriage on the base, and on it an arm of two joints and a wrist: three bodies, one freedom.
TEST(PostureHolding, HoldsJointsOfMechanisms) {
  ChainBuilder track("track"), arm("arm");
  track.actuator("s", Motion::tx, 1e7, 0.1);
  arm.actuator("q1", Motion::rz, 1e4, 1.5).offset(Pose::translation({0.5, 0, 0}));
  arm.actuator("q2", Motion::rz, 1e4, -1.2).offset(Pose::translation({0.4, 0, 0}));
  arm.actuator("q3", Motion::rz, 1e4);
  const Manipulator machine("on a track", {arm.build(), track.build()},
                            {{1, Span::platform}, {Span::base, 1}}, {"carriage"});
  const Pose target = Pose::translation({0.6, 0.5, 0});
  for (const double s : {-0.05, 0.1, 0.3, 0.55}) {
    const PostureResult result = posture_holding(machine, target, {{"track.s", s}});
    ASSERT_TRUE(result.reached) << s << ": " << result.reason;
    EXPECT_EQ(result.posture.coordinates[1][0], s);
    const Eigen::VectorXd& q = result.posture.coordinates[0];
    // Law of cosines; the elbow stays on its side.
    const double square = (0.6 - s) * (0.6 - s) + 0.25;
    EXPECT_NEAR(q[1], -std::acos((square - 0.25 - 0.16) / (2 * 0.5 * 0.4)), 1e-9) << s;
  }
  EXPECT_FALSE(posture_holding(machine, target, {{"s", -0.3}}).reached);  // too far away
}

}  // namespace
}  // namespace kinetostat::vjm::posture_test
