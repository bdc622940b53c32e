#include "kinetostat/spatial/pose.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"

#include "support/matrix_near.h"
#include "support/random.h"

namespace kinetostat::spatial::pose_test {
namespace {

using test::matrix_near;
using test::Random;

testing::AssertionResult pose_near(const Pose& actual, const Pose& expected, double tolerance) {
  const auto rotation = matrix_near(actual.rotation(), expected.rotation(), tolerance);
  return rotation ? matrix_near(actual.position(), expected.position(), tolerance) : rotation;
}

TEST(Pose, ComposesAsItsActionOnPoints) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose a = random.pose(), b = random.pose();
    const Vector3 point = random.vector();
    EXPECT_TRUE(matrix_near((a * b) * point, a * (b * point), 1e-14));
    EXPECT_TRUE(pose_near(a * a.inverse(), Pose(), 1e-14));
    EXPECT_TRUE(pose_near((a * b).inverse(), b.inverse() * a.inverse(), 1e-14));
  }
}

TEST(Pose, RefusesWhatIsNotARotation) {
  EXPECT_THROW(Pose(2 * Matrix3::Identity(), Vector3::Zero()), std::invalid_argument);
  EXPECT_THROW(Pose(-Matrix3::Identity(), Vector3::Zero()), std::invalid_argument);
}

TEST(Pose, ExpAndLogAreInverse) {
  Random random(2);
  for (const double angle : {0.0, 1e-10, 1e-3, 1.0, 3.0}) {
    Vector6 screw;
    screw << random.vector(), angle * random.direction();
    EXPECT_TRUE(matrix_near(log_pose(exp_pose(screw)), screw, 1e-13)) << "angle " << angle;
  }
}

// The motion of constant twist obeys X(s + t) = X(s) X(t), and each point p moves with v + w x p.
TEST(Pose, ExpIsTheMotionOfConstantTwist) {
  Random random(3);
  const Vector6 screw = random.matrix<6>();
  EXPECT_TRUE(
      pose_near(exp_pose(0.3 * screw) * exp_pose(0.5 * screw), exp_pose(0.8 * screw), 1e-14));
  const double step = 1e-6;
  const Vector3 point = random.vector();
  const Vector3 velocity =
      (exp_pose(step * screw) * point - exp_pose(-step * screw) * point) / (2 * step);
  EXPECT_TRUE(matrix_near(velocity, screw.head<3>() + screw.tail<3>().cross(point), 1e-9));
}

TEST(Pose, DisplacedUndoesTheDifference) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const Pose from = random.pose(), to = random.pose();
    EXPECT_TRUE(pose_near(displaced(from, pose_difference(from, to)), to, 1e-13));
  }
}

TEST(Pose, DifferenceIsInTheCommonAxes) {
  const Pose from(exp_rotation({0, 0, 1.5}), {1, 2, 3});
  const Pose to(exp_rotation({0.1, 0, 0}) * from.rotation(), {1, 2, 5});
  Vector6 expected;
  expected << 0, 0, 2, 0.1, 0, 0;
  EXPECT_TRUE(matrix_near(pose_difference(from, to), expected, 1e-14));
}

}  // namespace
}  // namespace kinetostat::spatial::pose_test
