// The U R R S chain of MMT11 section 6.1 in its three models and postures, against the critical
// forces that an independent program gave for it. Its shear modulus is not stated: where the links
// twist, the last digit is open.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "kinetostat/vjm/beam.h"
#include "kinetostat/vjm/path.h"
#include "kinetostat/vjm/posture.h"

namespace kinetostat::vjm {
namespace {

using spatial::Compliance6;
using spatial::Pose;
using spatial::Vector6;

constexpr double length = 0.3, k0 = 393.75;  // 70 GPa, 15 x 6 mm

enum class Springs { actuators, planar, spatial, planar_beam, spatial_beam };
enum class Shape { straight, bent, zigzag };

struct Case {
  Springs springs;
  Shape shape;
  double critical;   // [K0 / L]; 0: none on the way
  double precision;  // of the printed value
};

// What gives way at the end of a link.
void add_link(Chain& chain, Springs springs, int number) {
  const std::string n = std::to_string(number);
  const Pose offset = Pose::translation({length, 0, 0});
  Section section = Section::rectangle(0.015, 0.006);
  const Material material{70e9, 70e9 / 2.66, std::nullopt};
  const double torsion = material.shear_modulus * section.torsion_constant / length;
  const double axial = 70e9 * section.area / length;
  switch (springs) {
    case Springs::actuators:
      chain.offset(offset);
      return;
    case Springs::planar:
      chain.offset(offset).passive("s" + n, Motion::tx, axial, 0, 0);
      chain.passive("b" + n, Motion::rz, k0, 0, 0);
      return;
    case Springs::spatial:
      chain.offset(offset).passive("t" + n, Motion::rx, torsion, 0, 0);
      chain.passive("c" + n, Motion::ry, 0.16 * k0, 0, 0);
      chain.passive("b" + n, Motion::rz, k0, 0, 0);
      return;
    case Springs::planar_beam:
      section.second_moment_y *= 1e6;  // stays in its plane
      section.torsion_constant *= 1e6;
      [[fallthrough]];
    case Springs::spatial_beam:
      chain.link(
          "l" + n, offset,
          Compliance6(
              beam_compliance(length, section, material, BeamTheory::euler_bernoulli).matrix()));
  }
}

Manipulator urrs(Springs springs) {
  const bool planar = springs == Springs::planar || springs == Springs::planar_beam;
  const std::optional<double> actuator =
      springs == Springs::actuators ? std::optional(k0) : std::nullopt;
  Chain chain("urrs");
  chain.passive("u", Motion::rz);
  if (!planar) chain.passive("u2", Motion::ry);
  add_link(chain, springs, 1);
  chain.actuator("a1", Motion::rz, actuator);
  add_link(chain, springs, 2);
  chain.actuator("a2", Motion::rz, actuator);
  add_link(chain, springs, 3);
  if (!planar) chain.passive("s.Rx", Motion::rx).passive("s.Ry", Motion::ry);
  chain.passive("s.Rz", Motion::rz);
  return {"urrs", {chain}};
}

Posture posture(const Manipulator& robot, Shape shape) {
  const double bend = std::numbers::pi / 6;
  switch (shape) {
    case Shape::straight:
      return posture_from_joints(robot, {}).posture;
    case Shape::bent:
      return posture_from_joints(robot, {{"u", bend}, {"a1", -bend}, {"a2", -bend}}).posture;
    case Shape::zigzag:
      break;
  }
  // 2 sin(u) + sin(u + bend) = 0: both ends on the x axis.
  const double u = -std::atan2(std::sin(bend), 2 + std::cos(bend));
  return posture_from_joints(robot, {{"u", u}, {"a1", bend}, {"a2", -bend}}).posture;
}

class CriticalForce : public ::testing::TestWithParam<Case> {};

TEST_P(CriticalForce, IsThatOfAnIndependentProgram) {
  const Case& c = GetParam();
  const Manipulator robot = urrs(c.springs);
  PathTask task;
  task.displacement = -0.5 * length * Vector6::Unit(0);
  PathOptions options;
  options.until_critical = true;
  files::Progress progress;
  const Path path = trace(robot, posture(robot, c.shape), task, options, progress);
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
}  // namespace kinetostat::vjm
