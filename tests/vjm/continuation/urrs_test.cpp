// The U R R S chain of MMT11 section 6.1 in its three models and postures, against the critical
// forces that an independent program gave for it. Its shear modulus is not stated: where the links
// twist, the last digit is open.
#include "vjm/urrs.h"

#include <gtest/gtest.h>

#include "kinetostat/vjm/continuation/path.h"

namespace kinetostat::vjm::urrs_test {
namespace {

using samples::k0;
using samples::length;
using samples::Shape;
using samples::Springs;
using samples::urrs;
using spatial::Vector6;

struct Case {
  Springs springs;
  Shape shape;
  double critical;   // [K0 / L]; 0: none on the way
  double precision;  // of the printed value
};

class CriticalForce : public ::testing::TestWithParam<Case> {};

TEST_P(CriticalForce, IsThatOfAnIndependentProgram) {
  const Case& c = GetParam();
  const Manipulator robot = urrs(c.springs);
  PathTask task;
  task.displacement = -0.5 * length * Vector6::Unit(0);
  PathOptions options;
  options.until_critical = true;
  common::Progress progress;
  const Path path = trace(robot, samples::posture(robot, c.shape), task, options, progress);
  if (c.critical == 0) {
    EXPECT_TRUE(path.critical.empty());
    EXPECT_EQ(path.branches[0].end, BranchEnd::target);
    return;
  }
  ASSERT_EQ(path.critical.size(), 1U);
  EXPECT_NEAR(path.critical[0].point.along->force * length / k0, c.critical, c.precision);
}

INSTANTIATE_TEST_SUITE_P(
    ReferenceValues, CriticalForce,
    ::testing::Values(Case{Springs::actuators, Shape::straight, 1, 1e-8},
                      Case{Springs::actuators, Shape::bent, 0, 0},
                      Case{Springs::actuators, Shape::zigzag, 1.0335, 6e-5},
                      Case{Springs::planar, Shape::straight, 1.0002, 6e-5},
                      Case{Springs::planar, Shape::bent, 0, 0},
                      Case{Springs::planar, Shape::zigzag, 1.034, 6e-4},
                      Case{Springs::spatial, Shape::straight, 0.16, 1e-8},
                      Case{Springs::spatial, Shape::bent, 0.2000, 6e-5},
                      Case{Springs::spatial, Shape::zigzag, 0.1693, 3e-4},
                      Case{Springs::planar_beam, Shape::straight, 1.583, 6e-4},
                      Case{Springs::planar_beam, Shape::bent, 0, 0},
                      Case{Springs::planar_beam, Shape::zigzag, 0, 0},
                      Case{Springs::spatial_beam, Shape::straight, 0.2531, 2e-4},
                      Case{Springs::spatial_beam, Shape::bent, 0.2719, 4e-4},
                      Case{Springs::spatial_beam, Shape::zigzag, 0.2677, 4e-4}));

}  // namespace
}  // namespace kinetostat::vjm::urrs_test
