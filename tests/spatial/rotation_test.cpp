#include "kinetostat/spatial/rotation.h"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/matrix_near.h"
#include "support/random.h"

namespace kinetostat::spatial::rotation_test {
namespace {

using test::matrix_near;
using test::Random;

constexpr double pi = 3.14159265358979323846;
// Where closed forms lose digits, where the series end, and the ends of the range.
constexpr std::array angles{0.0,      1e-300,   1e-20,     1e-12,     1e-8,     1e-5,
                            0.999e-3, 1.001e-3, 0.01,      0.5,       1.0,      pi / 2.0,
                            2.0,      3.0,      pi - 1e-3, pi - 1e-6, pi - 1e-9};

TEST(Rotation, ExpThenLogGivesTheVectorBackAtEveryAngle) {
  Random random(1);
  for (const double angle : angles)
    for (int i = 0; i < 20; ++i) {
      const Vector3 v = angle * random.direction();
      EXPECT_TRUE(matrix_near(log_rotation(exp_rotation(v)), v, 1e-14 * (1 + angle)))
          << "angle " << angle;
    }
}

TEST(Rotation, ExpIsARotationAboutItsVector) {
  Random random(2);
  for (const double angle : angles) {
    const Vector3 v = angle * random.direction();
    const Matrix3 rotation = exp_rotation(v);
    EXPECT_TRUE(is_rotation(rotation, 1e-14));
    EXPECT_TRUE(matrix_near(rotation * v, v, 1e-14));
    EXPECT_NEAR(rotation.trace(), 1 + 2 * std::cos(angle), 1e-14);
  }
}

TEST(Rotation, QuarterTurnAboutZTakesXToY) {
  EXPECT_TRUE(
      matrix_near(exp_rotation({0, 0, pi / 2}) * Vector3::UnitX(), Vector3::UnitY(), 1e-15));
}

TEST(Rotation, AnglesBeyondPiComeBackTheShortWay) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Vector3 axis = random.direction();
    const double angle = random.uniform(pi + 0.01, 2 * pi - 0.01);
    EXPECT_TRUE(
        matrix_near(log_rotation(exp_rotation(angle * axis)), (angle - 2 * pi) * axis, 1e-13));
  }
}

TEST(Rotation, HalfTurnsTakeTheVectorWhoseFirstComponentIsPositive) {
  for (const Vector3& axis :
       {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(0.6, -0.8, 0),
        Vector3(0, 0.6, -0.8), Vector3(0.6, 0, -0.8)}) {
    const Matrix3 half_turn = 2 * axis * axis.transpose() - Matrix3::Identity();
    EXPECT_TRUE(matrix_near(log_rotation(half_turn), pi * axis, 1e-14));
  }
}

// exp(v + dv) = exp(J dv) exp(v), so J dv = log(exp(v + dv) exp(-v)) to first order.
TEST(Rotation, LeftJacobianIsTheDerivativeOfExp) {
  Random random(4);
  const double step = 1e-5;
  for (const double angle : {0.0, 1e-6, 0.9e-3, 1.1e-3, 0.1, 1.0, 2.0, 3.0, 4.5}) {
    const Vector3 v = angle * random.direction();
    Matrix3 numerical;
    for (int i = 0; i < 3; ++i) {
      const Vector3 dv = step * Vector3::Unit(i);
      const Matrix3 back = exp_rotation(-v);
      numerical.col(i) =
          (log_rotation(exp_rotation(v + dv) * back) - log_rotation(exp_rotation(v - dv) * back)) /
          (2 * step);
    }
    EXPECT_TRUE(matrix_near(left_jacobian(v), numerical, 1e-9)) << "angle " << angle;
  }
}

TEST(Rotation, LeftJacobianInverseIsTheInverse) {
  Random random(5);
  for (const double angle : {0.0, 1e-9, 0.999e-3, 1.001e-3, 0.5, 2.0, pi, 4.0, 6.0}) {
    const Vector3 v = angle * random.direction();
    EXPECT_TRUE(
        matrix_near(left_jacobian(v) * left_jacobian_inverse(v), Matrix3::Identity(), 1e-13))
        << "angle " << angle;
  }
}

TEST(Rotation, RollPitchYawTurnsAboutFixedXThenYThenZ) {
  const double roll = 0.3, pitch = -0.7, yaw = 1.9;
  const Matrix3 expected =
      exp_rotation({0, 0, yaw}) * exp_rotation({0, pitch, 0}) * exp_rotation({roll, 0, 0});
  EXPECT_TRUE(matrix_near(rotation_from_rpy({roll, pitch, yaw}), expected, 1e-15));
}

TEST(Rotation, AxesKeepTheDirectionOfXAndTheHalfPlaneOfY) {
  const Matrix3 rotation = rotation_from_axes({0, 2, 0}, {-1, 5, 0});
  EXPECT_TRUE(is_rotation(rotation));
  EXPECT_TRUE(matrix_near(rotation.col(0), Vector3::UnitY(), 1e-15));
  EXPECT_TRUE(matrix_near(rotation.col(1), -Vector3::UnitX(), 1e-15));
}

TEST(Rotation, AxesThatDefineNoRotationAreRefused) {
  EXPECT_THROW(rotation_from_axes({0, 0, 0}, {0, 1, 0}), std::invalid_argument);
  EXPECT_THROW(rotation_from_axes({1, 0, 0}, {-2, 0, 0}), std::invalid_argument);
}

TEST(Rotation, MirrorsAndStretchesAreNotRotations) {
  EXPECT_TRUE(is_rotation(Matrix3::Identity()));
  EXPECT_FALSE(is_rotation(-Matrix3::Identity()));
  EXPECT_FALSE(is_rotation(1.001 * Matrix3::Identity()));
  EXPECT_FALSE(is_rotation(Matrix3::Constant(std::numeric_limits<double>::quiet_NaN())));
}

}  // namespace
}  // namespace kinetostat::spatial::rotation_test
