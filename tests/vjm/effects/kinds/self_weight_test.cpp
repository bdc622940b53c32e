// A link that weighs more than the model knows, of any kind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/vjm/effects/effect.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "vjm/robot_text.h"

namespace kinetostat::vjm::self_weight_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Elastic joints, rigid links: the fore arm has a mass, the upper arm none, and a motor sits on it.
std::string arm_with(const std::string& effects) {
  return "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
         "gravity: {direction: [0, 0, -1], acceleration: 10 m/s^2}\n"
         "links:\n"
         "  upper: {rigid: [500, 0, 0]}\n"
         "  fore: {rigid: [400, 0, 0], mass: {mass: 8 kg, center: [150, 0, 0]}}\n"
         "chain_types:\n  arm:\n"
         "    - actuator: {name: q1, axis: Ry, stiffness: 4.0e6 N m/rad}\n    - link: upper\n"
         "    - mass: {name: motor, mass: 4 kg, at: [-100, 0, 0]}\n"
         "    - actuator: {name: q2, axis: Ry, stiffness: 2.0e6 N m/rad}\n    - link: fore\n"
         "manipulator: {chain: arm}\n" +
         effects;
}

std::pair<double, double> angles(const std::string& effects) {
  const Robot robot = robot_from(arm_with(effects));
  const Equilibrium e = equilibrium_under_load(
      robot.manipulator, posture_from_joints(robot.manipulator, {}).posture, {});
  return {e.chains[0].coordinates[0], e.chains[0].coordinates[1]};
}

TEST(SelfWeight, ActsOnRigidLinksWithAMassAndOnMasses) {
  const Robot robot = robot_from(arm_with(""));
  const auto kind = effect_kind("self_weight");
  EXPECT_THAT(effect_places(*kind, robot.manipulator),
              ElementsAre("arm.motor", "motor", "arm.fore", "fore"));
  EXPECT_THAT(effect_places(*effect_kind("link_compliance"), robot.manipulator), ElementsAre());
  try {
    (void)effect_sites(*kind, robot.manipulator, "upper");
    FAIL() << "a rigid link without mass was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(std::string(error.what()), HasSubstr("upper"));
  }
}

// 6 kg more, where the mass of the link is: moments by hand.
TEST(SelfWeight, IsWhereTheMassOfTheLinkIs) {
  const auto [p1, p2] = angles("");
  const auto [f1, f2] = angles("effects: [{effect: self_weight, at: fore, mass: 6 kg}]\n");
  EXPECT_NEAR(f1 - p1, 60 * 0.65 / 4e6, 1e-13);
  EXPECT_NEAR(f2 - p2, 60 * 0.15 / 2e6, 1e-13);
  const auto [m1, m2] = angles("effects: [{effect: self_weight, at: motor, mass: 6 kg}]\n");
  EXPECT_NEAR(m1 - p1, 60 * 0.4 / 4e6, 1e-13);
  EXPECT_NEAR(m2 - p2, 0, 1e-13);
}

// A flexible link whose own mass has its centre aside: the heavier link has its own there, too.
TEST(SelfWeight, OfAFlexibleLinkWithAMassIsThatMassGrown) {
  const auto sag = [](double mass, const std::string& effects) {
    const Robot robot = robot_from(
        "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
        "gravity: {direction: [0, 0, -1]}\nlinks:\n"
        "  boom: {end: [500, 0, 0], mass: {mass: " +
        std::to_string(mass) +
        " kg, center: [100, 50, 0]}, compliance: [[1e-5,0,0,0,0,0],[0,1e-4,0,0,0,0],"
        "[0,0,1e-4,0,0,0],[0,0,0,1e-9,0,0],[0,0,0,0,1e-9,0],[0,0,0,0,0,1e-9]]}\n"
        "chain_types: {arm: [{actuator: {name: q, axis: Rx, stiffness: 1.0e6}}, {link: boom}]}\n"
        "manipulator: {chain: arm}\n" +
        effects);
    return equilibrium_under_load(robot.manipulator,
                                  posture_from_joints(robot.manipulator, {}).posture, {})
        .displacement.coordinates();
  };
  const auto heavier = sag(14, "");
  const auto grown = sag(8, "effects: [{effect: self_weight, at: boom, mass: 6 kg}]\n");
  EXPECT_LT((grown - heavier).norm(), 1e-12 * heavier.norm());
}

}  // namespace
}  // namespace kinetostat::vjm::self_weight_test
