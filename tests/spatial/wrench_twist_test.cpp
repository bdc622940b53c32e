#include "kinetostat/spatial/wrench_twist.h"

#include <gtest/gtest.h>

#include "support/matrix_near.h"
#include "support/random.h"

namespace kinetostat::spatial::wrench_twist_test {
namespace {

using test::matrix_near;
using test::Random;

// A force of 10 N along y at x = 2 m has the moment 20 N m about z at the origin.
TEST(Wrench, ForceBesideThePointGivesAMoment) {
  const Wrench at_tip{{0, 10, 0}, {0, 0, 0}, {.point = {2, 0, 0}}};
  const Wrench at_origin = at_tip.in({});
  EXPECT_TRUE(matrix_near(at_origin.force, Vector3(0, 10, 0), 0));
  EXPECT_TRUE(matrix_near(at_origin.moment, Vector3(0, 0, 20), 1e-15));
}

// A rotation of 0.1 rad about z at the origin moves the point x = 2 m by 0.2 m along y.
TEST(Twist, RotationMovesAPointBeside) {
  const Twist at_origin{{0, 0, 0}, {0, 0, 0.1}, {}};
  const Twist at_tip = at_origin.in({.point = {2, 0, 0}});
  EXPECT_TRUE(matrix_near(at_tip.translation, Vector3(0, 0.2, 0), 1e-15));
}

TEST(Wrench, AxesAreTheColumns) {
  Matrix3 quarter;  // x' = y, y' = -x
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Wrench turned = Wrench{{0, 10, 0}, {}, {}}.in({.axes = quarter});
  EXPECT_TRUE(matrix_near(turned.force, Vector3(10, 0, 0), 0));
}

TEST(Transforms, PowerDoesNotDependOnTheFrame) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Frame a = random.frame(), b = random.frame(), c = random.frame();
    const Wrench wrench = Wrench::from_coordinates(random.matrix<6>(), a);
    const Twist twist = Twist::from_coordinates(random.matrix<6>(), b);
    const double in_a = wrench.coordinates().dot(twist.in(a).coordinates());
    EXPECT_NEAR(work(wrench, twist), in_a, 1e-13);
    EXPECT_NEAR(work(wrench.in(c), twist), in_a, 1e-13);
    EXPECT_NEAR(work(wrench, twist.in(c)), in_a, 1e-13);
  }
}

TEST(Transforms, FormAGroup) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Frame a = random.frame(), b = random.frame(), c = random.frame();
    const Matrix6 identity = Matrix6::Identity();
    EXPECT_TRUE(matrix_near(wrench_transform(b, c) * wrench_transform(a, b), wrench_transform(a, c),
                            1e-13));
    EXPECT_TRUE(
        matrix_near(twist_transform(b, c) * twist_transform(a, b), twist_transform(a, c), 1e-13));
    EXPECT_TRUE(matrix_near(wrench_transform(b, a) * wrench_transform(a, b), identity, 1e-13));
    EXPECT_TRUE(matrix_near(twist_transform(b, a) * twist_transform(a, b), identity, 1e-13));
  }
}

TEST(Transforms, TwistTransformIsTheInverseTransposeOfTheWrenchTransform) {
  Random random(3);
  const Frame a = random.frame(), b = random.frame();
  EXPECT_TRUE(matrix_near(twist_transform(a, b).transpose() * wrench_transform(a, b),
                          Matrix6::Identity(), 1e-14));
}

TEST(Transforms, SumsAreTakenInTheFrameOfTheLeftOperand) {
  Random random(4);
  const Frame a = random.frame(), b = random.frame();
  const Wrench f = Wrench::from_coordinates(random.matrix<6>(), a);
  const Wrench g = Wrench::from_coordinates(random.matrix<6>(), b);
  EXPECT_EQ((f + g).frame, a);
  EXPECT_TRUE(matrix_near((f + g).in(b).coordinates(), (g + f).coordinates(), 1e-14));
  const Twist u = Twist::from_coordinates(random.matrix<6>(), a);
  const Twist v = Twist::from_coordinates(random.matrix<6>(), b);
  EXPECT_TRUE(matrix_near((u + v).in(b).coordinates(), (v + u).coordinates(), 1e-14));
}

}  // namespace
}  // namespace kinetostat::spatial::wrench_twist_test
