// A drive that turns a joint behind it along.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/vjm/effects/effect.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "vjm/robot_text.h"

namespace kinetostat::vjm::joint_coupling_test {
namespace {

using testing::HasSubstr;

std::string scara_with(const std::string& effects) {
  return "kinetostat: 1\nname: scara\nunits: {length: mm, force: N, angle: rad}\n"
         "chain_types:\n  arm:\n"
         "    - actuator: {name: q1, axis: Rz, stiffness: 4.0e5 N m/rad}\n    - tool: [400, 0, 0]\n"
         "    - actuator: {name: q2, axis: Rz, stiffness: 2.0e5 N m/rad}\n    - tool: [300, 0, 0]\n"
         "    - actuator: {name: z, axis: Tz, stiffness: 5.0e6 N/m}\n"
         "    - actuator: {name: q4, axis: Rz, stiffness: 1.0e4 N m/rad}\n"
         "manipulator: {chain: arm}\n" +
         effects;
}

double wrist_angle(const std::string& effects) {
  const Robot robot = robot_from(scara_with(effects));
  const auto posture = posture_from_joints(robot.manipulator, {{"q1", 0.7}, {"q2", -0.4}}).posture;
  return equilibrium_under_load(robot.manipulator, posture, {}).chains[0].coordinates[3];
}

// The slide between elbow and wrist is passed over: belts run along it.
TEST(JointCoupling, CountsDrivesThatTurn) {
  EXPECT_NEAR(wrist_angle(""), 0, 1e-14);
  const std::string coupled = "effects: [{effect: joint_coupling, at: q4, ratio: 0.002";
  EXPECT_NEAR(wrist_angle(coupled + "}]\n"), 0.002 * -0.4, 1e-12);
  EXPECT_NEAR(wrist_angle(coupled + ", drives_back: 2}]\n"), 0.002 * 0.7, 1e-12);
  try {
    (void)wrist_angle(coupled + ", drives_back: 3}]\n");
    FAIL() << "a drive that is not there was accepted";
  } catch (const std::exception& error) {
    EXPECT_THAT(std::string(error.what()), HasSubstr("3 drives back that turns"));
  }
}

}  // namespace
}  // namespace kinetostat::vjm::joint_coupling_test
