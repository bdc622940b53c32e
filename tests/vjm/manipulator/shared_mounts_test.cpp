// A foundation under all chains and a tool that is held behind all of them, in series with the
// robot between them.
#include "kinetostat/vjm/manipulator/shared_mounts.h"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/effect_catalogue.h"
#include "vjm/robot_text.h"

namespace kinetostat::vjm::shared_mounts_test {
namespace {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;
using test::effect;

// Six legs of unequal stiffness that end at points whose middle is (10, -5, -40) mm.
const char* const hexapod = R"(kinetostat: 1
name: six legs
units: {length: mm, force: N, angle: deg}
chain_types:
  leg:
    - passive: {name: universal, axes: [Rx, Ry]}
    - actuator: {name: length, axis: Tz, stiffness: 2.5e7 N/m, home: 600}
    - passive: {name: spherical, axes: [Rx, Ry, Rz]}
manipulator:
  chains:
    - {name: a, type: leg, base: [440, -90, 0], platform_point: [180, -180, -50]}
    - {name: b, type: leg, base: [440, 90, 0], platform_point: [180, 180, -50]}
    - {name: c, type: leg, base: [-140, 430, 0], platform_point: [80, 240, -30]}
    - {name: d, type: leg, base: [-300, 330, 0], platform_point: [-240, 50, -30]}
    - {name: e, type: leg, base: [-300, -330, 0], platform_point: [-240, -60, -40]}
    - {name: f, type: leg, base: [-140, -430, 0], platform_point: [100, -260, -40]}
)";

class SharedMountsTest : public testing::Test {
 protected:
  SharedMountsTest()
      : robot(robot_from(hexapod).manipulator),
        posture(posture_at(robot, Pose::translation({0.02, -0.01, 0.58})).posture) {}

  // Motion of the platform at its reference point by a wrench there.
  Matrix6 compliance(const Manipulator& manipulator, const Posture& at) const {
    return unloaded_stiffness(manipulator, at).compliance.value().matrix();
  }
  Matrix6 compliance_with(const std::vector<Effect>& effects) const {
    const Manipulator with = with_effects(robot, effects);
    return compliance(with, mounts_of(effects).on(posture, with));
  }

  Manipulator robot;
  Posture posture;
};

// By a place that yields by u = c F and turn = d M, at `arm` from the reference point.
Matrix6 of_mount(const Vector3& arm, double shift, double turn) {
  Matrix6 result;
  for (int k = 0; k < 6; ++k) {
    const Vector3 force = Vector6::Unit(k).head<3>(), moment = Vector6::Unit(k).tail<3>();
    const Vector3 spin = turn * (moment - arm.cross(force));
    result.col(k) << shift * force - spin.cross(arm), spin;
  }
  return result;
}

TEST_F(SharedMountsTest, YieldInSeriesWithTheRobot) {
  const double shift = 3e-9, turn = 2e-8;
  const Matrix6 alone = compliance(robot, posture);
  EXPECT_LT((compliance_with({effect(robot, "base_compliance", "foundation", {shift, turn})}) -
             alone - of_mount(-posture.platform.position(), shift, turn))
                .norm(),
            1e-10 * alone.norm());
  const Vector3 middle(0.01, -0.005, -0.04);
  EXPECT_LT((compliance_with({effect(robot, "platform_compliance", "tool", {shift, turn})}) -
             alone - of_mount(posture.platform.rotation() * middle, shift, turn))
                .norm(),
            1e-10 * alone.norm());
}

// Chains that each stand on a spring of their own do not move together.
TEST_F(SharedMountsTest, AreNotThoseOfEveryChain) {
  const Matrix6 shared = compliance_with({effect(robot, "base_tilt", "foundation", {1e-8, 0, 0})});
  const Matrix6 single = compliance_with({effect(robot, "base_tilt", "base", {1e-8, 0, 0})});
  EXPECT_GT((shared - single).norm(), 0.01 * shared.norm());
}

TEST_F(SharedMountsTest, StandWhereTheyWereWithoutLoad) {
  const std::vector<Effect> effects = {effect(robot, "base_compliance", "foundation", {3e-9, 2e-8}),
                                       effect(robot, "platform_compliance", "tool", {3e-9, 2e-8})};
  const Manipulator with = with_effects(robot, effects);
  const Posture found = posture_at(with, posture.platform).posture;
  const Posture completed = mounts_of(effects).on(posture, with);
  ASSERT_EQ(found.inner_bodies.size(), 2u);
  for (std::size_t b = 0; b < 2; ++b)
    EXPECT_LT(spatial::pose_difference(found.inner_bodies[b], completed.inner_bodies[b]).norm(),
              1e-9);
  const Equilibrium e = equilibrium_under_load(with, completed, {});
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  EXPECT_LT(spatial::pose_difference(e.platform, posture.platform).norm(), 1e-12);
}

// What hangs on the platform loads both.
TEST_F(SharedMountsTest, CarryWeight) {
  const double mass = 40, gravity = 9.81, shift = 3e-9;
  const Manipulator heavy = robot.with_gravity({0, 0, -gravity});
  const Effect payload = effect(heavy, "payload", "platform", {mass, 0, 0, 0});
  const auto height = [&](std::vector<Effect> effects) {
    effects.push_back(payload);
    const Manipulator with = with_effects(heavy, effects);
    const Equilibrium e = equilibrium_under_load(with, mounts_of(effects).on(posture, with), {});
    EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    return e.platform.position().z();
  };
  const double sinks = shift * mass * gravity;
  EXPECT_NEAR(height({effect(heavy, "base_compliance", "foundation", {shift, 0})}),
              height({}) - sinks, 1e-4 * sinks);
  EXPECT_NEAR(height({effect(heavy, "platform_compliance", "tool", {shift, 0})}),
              height({}) - sinks, 1e-4 * sinks);
}

TEST_F(SharedMountsTest, AreOfSeveralChainsAlone) {
  const auto kind = effect_kind("base_compliance");
  const std::vector<std::string> places = effect_places(*kind, robot);
  EXPECT_NE(std::find(places.begin(), places.end(), "foundation"), places.end());
  const std::vector<std::string> of_arm = effect_places(
      *effect_kind("platform_compliance"), test::shipped("heavy_arm.yaml").manipulator);
  EXPECT_EQ(std::find(of_arm.begin(), of_arm.end(), "tool"), of_arm.end());
  EXPECT_THROW(effect_sites(*kind, robot, "tool"), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::shared_mounts_test
