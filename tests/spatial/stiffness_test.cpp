#include "kinetostat/spatial/stiffness.h"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "support/matrix_near.h"
#include "support/random.h"

namespace kinetostat::spatial::stiffness_test {
namespace {

using test::matrix_near;
using test::matrix_near_relative;
using test::Random;

// In real units the blocks differ by many orders of magnitude: N/m against N m/rad.
Matrix6 in_real_units(const Matrix6& matrix) {
  Vector6 scale;
  scale << Vector3::Constant(1e4), Vector3::Constant(1e-1);
  return scale.asDiagonal() * matrix * scale.asDiagonal();
}

TEST(Stiffness, InverseOfInverseIsTheSame) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Stiffness6 stiffness(in_real_units(random.positive_definite()), random.frame());
    const Compliance6 compliance = stiffness.inverse();
    EXPECT_EQ(compliance.frame(), stiffness.frame());
    EXPECT_TRUE(matrix_near_relative(compliance.inverse().matrix(), stiffness.matrix(), 1e-10));
  }
}

TEST(Stiffness, SingularMatricesHaveNoInverse) {
  Random random(2);
  Matrix6 singular = random.positive_definite();
  singular.row(5).setZero();
  singular.col(5).setZero();
  EXPECT_THROW(Stiffness6{singular}.inverse(), std::domain_error);
  EXPECT_THROW(Stiffness6{Matrix6::Zero()}.inverse(), std::domain_error);
  EXPECT_THROW(Compliance6{Matrix6::Zero()}.inverse(), std::domain_error);
  EXPECT_THROW(Stiffness6{Matrix6::Constant(std::numeric_limits<double>::quiet_NaN())}.inverse(),
               std::domain_error);
}

// A soft spring with a long reach is not singular, however far apart its units are.
TEST(Stiffness, DifferenceOfUnitsIsNotSingularity) {
  Vector6 diagonal;
  diagonal << Vector3::Constant(1e9), Vector3::Constant(1e-9);
  const Matrix6 inverse = Stiffness6(diagonal.asDiagonal()).inverse().matrix();
  EXPECT_DOUBLE_EQ(inverse(0, 0), 1e-9);
  EXPECT_DOUBLE_EQ(inverse(5, 5), 1e9);
}

TEST(Stiffness, ChangeOfFrameKeepsTheEnergy) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Stiffness6 stiffness(random.positive_definite(), random.frame());
    const Twist motion = Twist::from_coordinates(random.matrix<6>(), random.frame());
    const double energy = work(stiffness * motion, motion);
    EXPECT_NEAR(work(stiffness.in(random.frame()) * motion, motion), energy, 1e-11 * energy);
  }
}

TEST(Stiffness, ChangeOfFrameCommutesWithInversion) {
  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const Frame other = random.frame();
    const Stiffness6 stiffness(random.positive_definite(), random.frame());
    EXPECT_TRUE(matrix_near_relative(stiffness.in(other).inverse().matrix(),
                                     stiffness.inverse().in(other).matrix(), 1e-9));
    EXPECT_TRUE(matrix_near_relative(stiffness.in(other).in(stiffness.frame()).matrix(),
                                     stiffness.matrix(), 1e-12));
  }
}

TEST(Stiffness, WrenchOfTheDisplacementThatAWrenchCausesIsThatWrench) {
  Random random(5);
  const Compliance6 compliance(random.positive_definite(), random.frame());
  const Wrench wrench = Wrench::from_coordinates(random.matrix<6>(), random.frame());
  const Wrench back = compliance.inverse() * (compliance * wrench);
  EXPECT_TRUE(matrix_near(back.in(wrench.frame).coordinates(), wrench.coordinates(), 1e-11));
}

// A spring that only resists translation at a point P: about another point O, offset by p = P - O,
// it resists rotation with k (|p|^2 I - p p').
TEST(Stiffness, SpringAtADistanceResistsRotation) {
  const double k = 7;
  const Vector3 p(0.3, -0.2, 0.5);
  Matrix6 at_point = Matrix6::Zero();
  at_point.topLeftCorner<3, 3>() = k * Matrix3::Identity();
  const Matrix6 at_origin = Stiffness6(at_point, {.point = p}).in({}).matrix();
  EXPECT_TRUE(matrix_near(at_origin.bottomRightCorner<3, 3>(),
                          k * (p.squaredNorm() * Matrix3::Identity() - p * p.transpose()), 1e-14));
}

TEST(Stiffness, ParallelAddsStiffnessAndSeriesAddsCompliance) {
  Random random(6);
  const Frame a = random.frame(), b = random.frame();
  const Stiffness6 first(random.positive_definite(), a), second(random.positive_definite(), b);
  const Twist motion = Twist::from_coordinates(random.matrix<6>(), a);
  EXPECT_TRUE(matrix_near(((first + second) * motion).coordinates(),
                          (first * motion + second * motion).coordinates(), 1e-12));
  const Compliance6 c1 = first.inverse(), c2 = second.inverse();
  const Wrench wrench = Wrench::from_coordinates(random.matrix<6>(), a);
  EXPECT_TRUE(matrix_near_relative(((c1 + c2) * wrench).coordinates(),
                                   (c1 * wrench + c2 * wrench).coordinates(), 1e-12));
}

TEST(SymmetryDefect, IsTheLargestDifferenceInComparableUnits) {
  Random random(7);
  EXPECT_EQ(symmetry_defect(Matrix6::Zero()), 0);
  Matrix6 matrix = Matrix6::Identity();
  EXPECT_EQ(symmetry_defect(matrix), 0);
  matrix(0, 1) += 0.01;
  EXPECT_DOUBLE_EQ(symmetry_defect(matrix), 0.01);
}

TEST(SymmetryDefect, DoesNotDependOnTheUnitOfLength) {
  Random random(8);
  const Matrix6 matrix = random.positive_definite() + 0.01 * random.matrix<6, 6>();
  Vector6 metre_to_mm;
  metre_to_mm << Vector3::Constant(1e-3), Vector3::Ones();
  const Matrix6 in_mm = metre_to_mm.asDiagonal() * matrix * metre_to_mm.asDiagonal();
  EXPECT_NEAR(symmetry_defect(in_mm), symmetry_defect(matrix), 1e-14);
  EXPECT_GT(symmetry_defect(matrix), 0);
}

TEST(EigenStiffness, OfADiagonalComplianceAreItsReciprocals) {
  Vector6 compliance;
  compliance << 0.5, 0.25, 1.0, 0.1, 0.05, 0.02;
  const EigenStiffness eigen = eigen_stiffness(Compliance6(compliance.asDiagonal()));
  EXPECT_TRUE(matrix_near(eigen.translation, Vector3(1, 2, 4), 1e-14));
  EXPECT_TRUE(matrix_near(eigen.rotation, Vector3(10, 20, 50), 1e-13));
  EXPECT_NEAR(std::abs(eigen.translation_axes(2, 0)), 1, 1e-14);  // softest along z
}

// Force per displacement along an axis when the other motion is free: f / (axis' C f axis) = k.
TEST(EigenStiffness, IsTheStiffnessFeltAlongItsAxis) {
  Random random(9);
  const Compliance6 compliance(random.positive_definite(), random.frame());
  const EigenStiffness eigen = eigen_stiffness(compliance);
  for (int i = 0; i < 3; ++i) {
    const Vector3 axis = eigen.translation_axes.col(i);
    const Twist motion =
        compliance * Wrench{eigen.translation[i] * axis, {0, 0, 0}, compliance.frame()};
    EXPECT_TRUE(matrix_near(motion.translation, axis, 1e-12));
    const Vector3 turn = eigen.rotation_axes.col(i);
    const Twist rotation =
        compliance * Wrench{{0, 0, 0}, eigen.rotation[i] * turn, compliance.frame()};
    EXPECT_TRUE(matrix_near(rotation.rotation, turn, 1e-12));
  }
}

TEST(EigenStiffness, TurnsWithTheAxes) {
  Random random(10);
  const Compliance6 compliance(random.positive_definite());
  const Frame turned{Vector3::Zero(), random.rotation()};
  EXPECT_TRUE(matrix_near_relative(eigen_stiffness(compliance.in(turned)).translation,
                                   eigen_stiffness(compliance).translation, 1e-12));
}

}  // namespace
}  // namespace kinetostat::spatial::stiffness_test
