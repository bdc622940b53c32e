// Where a chain ends on a platform, and what is displaced there.
#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "support/matrix_near.h"
#include "vjm/robot_text.h"

namespace kinetostat::vjm::chain_end_test {
namespace {

using kinetostat::test::matrix_near;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

// A table on three rigid legs, each with slides along x, y, z, and the table's corner where it
// ends; the base frame of the first leg is turned by 90 degrees about z.
std::string table_with(const std::string& errors, const std::string& effects = "") {
  return "kinetostat: 1\nname: table\nunits: {length: mm, force: N, angle: rad}\n"
         "chain_types:\n  leg:\n"
         "    - passive: {name: px, axis: Tx, stiffness: 1.0e4}\n"
         "    - passive: {name: py, axis: Ty, stiffness: 2.0e4}\n"
         "    - actuator: {name: lift, axis: Tz, stiffness: 3.0e4}\n"
         "    - passive: {name: ball, axes: [Rx, Ry, Rz]}\n"
         "manipulator:\n  chains:\n"
         "    - {name: a, type: leg, base: {point: [400, 0, 0], rpy: [0, 0, 1.5707963267948966]},"
         " platform_point: [400, 0, 0]" +
         errors +
         "}\n"
         "    - {name: b, type: leg, base: [-200, 300, 0], platform_point: [-200, 300, 0]}\n"
         "    - {name: c, type: leg, base: [-200, -300, 0], platform_point: [-200, -300, 0]}\n" +
         effects;
}

Pose end_of(const Robot& robot, std::size_t c) {
  const Posture posture = posture_at(robot.manipulator, Pose()).posture;
  ChainKinematics kinematics;
  const Chain& chain = robot.manipulator.chains()[c];
  evaluate(chain, posture.coordinates_of(chain, c), kinematics);
  return kinematics.end;
}

// The corner stays where the leg holds it; the platform turns about the corner, in the leg's axes.
TEST(ChainEnd, AnErrorTurnsThePlatformAboutThePointOfAttachment) {
  const double angle = 0.01;
  const Pose end =
      end_of(robot_from(table_with(", errors: [{at: end, rotation_vector: [0, 0.01, 0]}]")), 0);
  // The leg's y axis is -x of the platform.
  const Pose turn = Pose::rotation(spatial::exp_rotation(Vector3(-angle, 0, 0)));
  const Vector3 corner(0.4, 0, 0);
  EXPECT_TRUE(matrix_near(end.rotation(), turn.rotation(), 1e-14));
  EXPECT_TRUE(matrix_near(end * corner, corner, 1e-14));
  const Pose about_z =
      end_of(robot_from(table_with(", errors: [{at: end, rotation_vector: [0, 0, 0.01]}]")), 0);
  EXPECT_TRUE(matrix_near(about_z * corner, corner, 1e-14));
  EXPECT_NEAR(about_z.position().y(), -0.4 * std::sin(angle), 1e-14);  // a lever arm of 400 mm
}

TEST(ChainEnd, AnErrorShiftsInTheAxesOfTheLastFrame) {
  const Pose end = end_of(robot_from(table_with(", errors: [{at: end, point: [1, 0, 0]}]")), 0);
  EXPECT_TRUE(matrix_near(end.position(), Vector3(0, 1e-3, 0), 1e-15));
}

// The error of the file and the effect of the catalogue are the same thing.
TEST(ChainEnd, TheGeometricErrorOfTheCatalogueActsThereToo) {
  const std::string effect =
      "effects: [{effect: geometric_error, at: a.end, x: 0.2, y: -0.1, z: 0.3, rx: 0.002, ry: "
      "0.01, rz: -0.004}]\n";
  const Robot file = robot_from(table_with(
      ", errors: [{at: end, point: [0.2, -0.1, 0.3], rotation_vector: [0.002, 0.01, -0.004]}]"));
  const Robot catalogue = robot_from(table_with("", effect));
  const Pose a = end_of(file, 0), b = end_of(catalogue, 0);
  EXPECT_TRUE(matrix_near(a.position(), b.position(), 1e-14));
  EXPECT_TRUE(matrix_near(a.rotation(), b.rotation(), 1e-14));
}

// The ball joint of the leg takes a turn at the corner up: nothing moves and nothing is strained.
TEST(ChainEnd, AssemblyFollowsThePointOfAttachment) {
  const Robot robot =
      robot_from(table_with(", errors: [{at: end, rotation_vector: [0, 0, 0.01]}]"));
  const Posture posture = posture_at(robot.manipulator, Pose()).posture;
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, {});
  ASSERT_EQ(e.status, EquilibriumStatus::converged);
  EXPECT_TRUE(matrix_near(e.displacement.coordinates(), Vector6(Vector6::Zero()), 1e-12));
  EXPECT_NEAR(e.energy, 0, 1e-15);
}

// A robot with errors has the unloaded stiffness of its nominal self, at the closed posture.
TEST(ChainEnd, UnloadedStiffnessIsThatOfTheNominalRobot) {
  const Robot nominal = robot_from(table_with(""));
  const Robot built = robot_from(
      table_with(", errors: [{at: lift, point: [0, 20, 0], rotation_vector: [0.1, 0.2, 0]}]"));
  const Posture posture = posture_at(nominal.manipulator, Pose()).posture;
  const auto stiffness = [&](const Robot& robot) {
    return unloaded_stiffness(robot.manipulator, posture).stiffness->matrix();
  };
  EXPECT_TRUE(matrix_near(stiffness(built), stiffness(nominal), 1e-9));
  EXPECT_TRUE(matrix_near(unloaded_stiffness_matrix(built.manipulator, posture)->matrix(),
                          stiffness(nominal), 1e-9));
}

// Without over-constraint errors do not strain, and the assembled stiffness is that of the shifted
// geometry: to first order in the error it differs from the nominal one.
TEST(ChainEnd, AssembledStiffnessDiffersFromTheUnloadedOneByTheError) {
  const auto difference = [](double error) {
    const Robot robot = robot_from(
        table_with(", errors: [{at: base, point: [" + std::to_string(error) + ", 0, 0]}]"));
    const Posture posture = posture_at(robot.manipulator, Pose()).posture;
    const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, {});
    const auto unloaded = unloaded_stiffness(robot.manipulator, posture).stiffness->matrix();
    return (e.stiffness->matrix() - unloaded).norm() / unloaded.norm();
  };
  const double large = difference(10), small = difference(1);
  EXPECT_GT(large, 1e-5);
  EXPECT_NEAR(large / small, 10, 0.5);
  EXPECT_LT(difference(1e-5), 1e-8);
}

// A payload sits on the platform wherever the chain that carries it ends.
TEST(ChainEnd, APayloadIsOnThePlatform) {
  const std::string gravity = "gravity: {direction: [0, 0, -1], acceleration: 10 m/s^2}\n";
  const Robot robot =
      robot_from(table_with("", gravity + "effects: [{effect: payload, at: platform, mass: 5 kg, "
                                          "x: 0, y: 0, z: 0}]\n"));
  const Posture posture = posture_at(robot.manipulator, Pose()).posture;
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, {});
  ASSERT_EQ(e.status, EquilibriumStatus::converged);
  // The weight is a load of leg a, which keeps a third of it; the others take the rest over.
  EXPECT_NEAR(e.chains[0].wrench.force.z(), 50 - 50.0 / 3, 1e-3);
  EXPECT_NEAR(e.chains[1].wrench.force.z(), -50.0 / 3, 1e-3);
}

}  // namespace
}  // namespace kinetostat::vjm::chain_end_test
