// The same link of a robot file more than once in a chain.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

#include "vjm/robot_text.h"

namespace kinetostat::vjm::repeated_link_test {
namespace {

using spatial::Vector3;
using testing::HasSubstr;

// Two joints about y with the same link behind each; `more`: of the manipulator.
std::string arm_with(const std::string& link, const std::string& more = "") {
  return "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
         "gravity: {direction: [0, 0, -1], acceleration: 10 m/s^2}\n"
         "materials: {steel: {E: 210 GPa, nu: 0.3, density: 7800 kg/m^3}}\n"
         "links:\n  boom: " +
         link +
         "\nchain_types:\n  arm:\n"
         "    - actuator: {name: q1, axis: Ry, stiffness: 4.0e6 N m/rad}\n    - link: boom\n"
         "    - actuator: {name: q2, axis: Ry, stiffness: 2.0e6 N m/rad}\n    - link: boom\n"
         "manipulator: {chain: arm" +
         more + "}\n";
}

Equilibrium under_weight(const Robot& robot) {
  return equilibrium_under_load(robot.manipulator,
                                posture_from_joints(robot.manipulator, {}).posture, {});
}

// Two booms of 12 kg and 0.5 m, centre of mass at 0.2 m: moments by hand.
TEST(RepeatedLink, ARigidLinkWeighsTwice) {
  const Robot robot =
      robot_from(arm_with("{rigid: [500, 0, 0], mass: {mass: 12 kg, center: [200, 0, 0]}}"));
  const Equilibrium e = under_weight(robot);
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  const double weight = 12 * 10, first = weight * (0.2 + 0.7), second = weight * 0.2;
  const double q1 = first / 4e6, q2 = second / 2e6;
  EXPECT_NEAR(e.chains[0].coordinates[0], q1, 1e-8 * q1);
  EXPECT_NEAR(e.chains[0].coordinates[1], q2, 1e-8 * q2);
  EXPECT_NEAR(e.displacement.translation.z(), -(q1 * 1.0 + q2 * 0.5), 1e-12);
}

// Every kind of link, its weight and its names.
TEST(RepeatedLink, AnyLinkHasNamesOfItsOwnEachTime) {
  const std::string soft =
      "[[1e-5,0,0,0,0,0],[0,1e-5,0,0,0,0],[0,0,1e-5,0,0,0],[0,0,0,1e-9,0,0],[0,0,0,0,1e-9,0],"
      "[0,0,0,0,0,1e-9]]";
  const std::string free =
      "[[1e5,0,0,0,0,0],[0,1e5,0,0,0,0],[0,0,1e5,0,0,0],[0,0,0,0,0,0],[0,0,0,0,1e9,0],"
      "[0,0,0,0,0,1e9]]";
  const std::string mass = ", mass: {mass: 3 kg, center: [100, 0, 0]}}";
  const std::string beam = "length: 500, section: {circle: {diameter: 60}}, material: steel";
  struct Kind {
    std::string link;
    double mass;
    std::vector<std::string> springs;
  };
  const std::vector<Kind> kinds = {
      {"{rigid: [500, 0, 0]}", 0, {}},
      {"{rigid: [500, 0, 0]" + mass, 6, {}},
      {"{compliance: " + soft + ", end: [500, 0, 0]" + mass, 6, {"boom", "boom#2"}},
      {"{stiffness: " + free + ", end: [500, 0, 0]" + mass, 6, {"boom", "boom#2"}},
      {"{beam: {" + beam + "}}", 2 * 7800 * M_PI * 0.03 * 0.03 * 0.5, {"boom", "boom#2"}},
      {"{beam: {" + beam + ", segments: 2}}",
       2 * 7800 * M_PI * 0.03 * 0.03 * 0.5,
       {"boom.1", "boom.2", "boom#2.1", "boom#2.2"}},
      {"{compliance: ../links/foot.link.json}", -1, {"boom", "boom#2"}},
      {"{manipulator: parallelogram.yaml, at: [310, 0, 0]}", 0, {"boom", "boom#2"}}};
  for (const Kind& kind : kinds) {
    SCOPED_TRACE(kind.link);
    const Robot robot = robot_from(arm_with(kind.link));
    const Chain& chain = robot.manipulator.chains()[0];
    double sum = 0;
    std::vector<std::string> springs;
    for (const PointMass& m : chain.masses()) sum += m.mass;
    for (const Spring& s : chain.springs())
      if (s.stiffness.rows() == 6) springs.push_back(s.name);
    if (kind.mass >= 0) {
      EXPECT_NEAR(sum, kind.mass, 1e-9);
    }
    EXPECT_EQ(springs, kind.springs);
  }
}

// An error is behind the use that it names.
TEST(RepeatedLink, AnErrorIsAtOneUse) {
  const auto end = [](const std::string& errors) {
    return under_weight(robot_from(arm_with("{rigid: [500, 0, 0]}", errors))).platform.position();
  };
  const Vector3 nominal = end("");
  const std::string turn = ", rotation_vector: [0, 0, 1 mrad]}]";
  const Vector3 first = end(", errors: [{at: boom" + turn) - nominal;
  const Vector3 second = end(", errors: [{at: boom#2, point: [0, 1, 0]}]") - nominal;
  EXPECT_NEAR(first.y(), 0.5e-3, 1e-9);
  EXPECT_NEAR(second.y(), 1e-3, 1e-12);
  try {
    end(", errors: [{at: boom#3" + turn);
    FAIL() << "was read";
  } catch (const common::InputError& error) {
    EXPECT_THAT(std::string(error.what()), HasSubstr("boom#2"));
  }
}

// Effects and uncertain stiffnesses name each use.
TEST(RepeatedLink, EffectsActOnOneUse) {
  const Robot robot =
      robot_from(arm_with("{rigid: [500, 0, 0], mass: {mass: 12 kg, center: [200, 0, 0]}}") +
                 "effects: [{effect: self_weight, at: boom#2, mass: 6 kg}]\n");
  const Equilibrium e = under_weight(robot);
  EXPECT_NEAR(e.chains[0].coordinates[0], (120 * (0.2 + 0.7) + 60 * 0.7) / 4e6, 1e-11);
  EXPECT_NEAR(e.chains[0].coordinates[1], (120 + 60) * 0.2 / 2e6, 1e-11);
}

}  // namespace
}  // namespace kinetostat::vjm::repeated_link_test
