// Postures and stiffnesses of many poses together against each pose alone.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/batches/lanes.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/batches/poses_about.h"

namespace kinetostat::vjm::stiffnesses_test {
namespace {

using samples::poses_about;
using samples::shipped;
using spatial::Pose;

void expect_as_alone(const Manipulator& manipulator, const std::vector<Pose>& poses) {
  const std::vector<PostureResult> together = postures_at(manipulator, poses);
  ASSERT_EQ(together.size(), poses.size());
  std::vector<Posture> reached;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const PostureResult alone = posture_at(manipulator, poses[i]);
    ASSERT_EQ(together[i].reached, alone.reached) << i;
    EXPECT_EQ(together[i].reason, alone.reason);
    if (!alone.reached) continue;
    reached.push_back(alone.posture);
    for (std::size_t c = 0; c < manipulator.size(); ++c)
      EXPECT_LT((together[i].posture.coordinates[c] - alone.posture.coordinates[c]).norm(),
                1e-9 * (1 + alone.posture.coordinates[c].norm()))
          << i << " " << c;
  }
  ASSERT_GT(reached.size(), poses.size() / 2);
  const auto stiffnesses = unloaded_stiffness_matrices(manipulator, reached);
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const auto alone = unloaded_stiffness_matrix(manipulator, reached[i]);
    ASSERT_EQ(stiffnesses[i].has_value(), alone.has_value());
    if (!alone) continue;
    EXPECT_LT((stiffnesses[i]->matrix() - alone->matrix()).norm(), 1e-11 * alone->matrix().norm())
        << i;
    EXPECT_EQ(stiffnesses[i]->frame().point, alone->frame().point);
  }
}

struct Shipped {
  const char* file;
  double spread;    // [m]
  double turn = 0;  // [rad], where the platform turns at all
};
class ShippedRobot : public testing::TestWithParam<Shipped> {};

TEST_P(ShippedRobot, ManyPosesAsEachAlone) {
  const Manipulator robot = shipped(GetParam().file).manipulator;
  expect_as_alone(robot, poses_about(robot, GetParam().spread, GetParam().turn, 41));
}

INSTANTIATE_TEST_SUITE_P(
    Robots, ShippedRobot,
    testing::Values(Shipped{"orthoglide.yaml", 0.05}, Shipped{"orthoglide_errors.yaml", 0.02},
                    Shipped{"orthoglide_frame.yaml", 0.02}, Shipped{"orthoglide_prpar.yaml", 0.02},
                    Shipped{"delta.yaml", 0.03}, Shipped{"gantry.yaml", 0.05},
                    Shipped{"heavy_arm.yaml", 0.03, 0.02}, Shipped{"six_axis.yaml", 0.05, 0.3},
                    Shipped{"stewart_gough_a.yaml", 0.03, 0.1},
                    Shipped{"translational_3puu.yaml", 0.02}),
    [](const auto& one) {
      const std::string file = one.param.file;
      return file.substr(0, file.find('.'));
    });

// Straight it is rigid along itself, which only the way for one posture can say.
TEST(ManyPoses, ARigidChainGoesAlone) {
  const Manipulator robot = shipped("urrs_a.yaml").manipulator;
  const Posture straight = posture_from_joints(robot, {}).posture;
  ASSERT_FALSE(unloaded_stiffness_matrix(robot, straight));
  for (const auto& stiffness : unloaded_stiffness_matrices(robot, {straight, straight, straight}))
    EXPECT_FALSE(stiffness);
}

TEST(ManyPoses, NoneAreNoTrouble) {
  const Manipulator robot = shipped("orthoglide.yaml").manipulator;
  EXPECT_TRUE(postures_at(robot, {}).empty());
  EXPECT_TRUE(unloaded_stiffness_matrices(robot, {}).empty());
}

TEST(ManyPoses, APoseDoesNotKnowOfTheOthers) {
  const Manipulator robot = shipped("orthoglide.yaml").manipulator;
  const std::vector<Pose> poses = poses_about(robot, 0.05, 0, 13);
  const std::vector<PostureResult> together = postures_at(robot, poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const PostureResult alone = postures_at(robot, {poses[i]}).front();
    ASSERT_EQ(alone.reached, together[i].reached);
    for (std::size_t c = 0; alone.reached && c < robot.size(); ++c)
      EXPECT_EQ(alone.posture.coordinates[c], together[i].posture.coordinates[c]);
  }
}

// Products and quotients in all kinds of registers, to the last bit those of a double.
TEST(Lanes, AreNumbersToTheLastBit) {
  const double a[lane_count] = {1.0 / 3, -2e-9, 7e11, 0.1},
               b[lane_count] = {3.7, 1e3, -1.0 / 7, 0.3};
  Lanes x, y, narrow, wide;
  for (int lane = 0; lane < lane_count; ++lane) {
    x.set(lane, a[lane]);
    y.set(lane, b[lane]);
  }
  const auto work = [&](Lanes& z) { z = (x * y + x) / (y - x * x) - sqrt(abs(x)) * y; };
  in_narrow_lanes([&] { work(narrow); });
  in_lanes([&] { work(wide); });
  for (int lane = 0; lane < lane_count; ++lane) {
    const double p = a[lane], q = b[lane];
    const double alone = (p * q + p) / (q - p * p) - std::sqrt(std::abs(p)) * q;
    EXPECT_EQ(narrow[lane], alone);
    EXPECT_EQ(wide[lane], alone);
  }
}

// Beside the library's, over all quarters, at their ends and far out, one lane beside another.
TEST(Lanes, HaveSineAndCosine) {
  constexpr double quarter = 1.5707963267948966, digit = std::numeric_limits<double>::epsilon();
  double largest = 0;
  for (int i = -4000; i <= 4000; ++i) {
    const double angles[lane_count] = {i * quarter / 400, i * quarter, i * 1e-11, i * 12345.678};
    Lanes x, sine, cosine, wide_sine, wide_cosine;
    for (int lane = 0; lane < lane_count; ++lane) x.set(lane, angles[lane]);
    in_narrow_lanes([&] { sine_and_cosine(x, sine, cosine); });
    in_lanes([&] { sine_and_cosine(x, wide_sine, wide_cosine); });
    for (int lane = 0; lane < lane_count; ++lane) {
      largest = std::max({largest, std::abs(sine[lane] - std::sin(angles[lane])),
                          std::abs(cosine[lane] - std::cos(angles[lane]))});
      EXPECT_EQ(sine[lane], wide_sine[lane]);
      EXPECT_EQ(cosine[lane], wide_cosine[lane]);
    }
  }
  EXPECT_LE(largest, 2 * digit);
  Lanes small(1e-300), far(INFINITY), sine, cosine;
  sine_and_cosine(small, sine, cosine);
  EXPECT_EQ(sine[0], 1e-300);
  sine_and_cosine(far, sine, cosine);
  EXPECT_TRUE(std::isnan(sine[0]) && std::isnan(cosine[0]));
}

}  // namespace
}  // namespace kinetostat::vjm::stiffnesses_test
