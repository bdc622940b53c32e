#include "kinetostat/calibration/comparison/joint_curve.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/vjm/io/effect_file.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::joint_curve_test {
namespace {

constexpr char slide[] = R"(kinetostat: 1
name: slide
units: {length: mm, force: N, angle: deg}
chain_types: {slide: [{actuator: {name: rho, axis: Tz, stiffness: 40000}}]}
manipulator: {chains: [{name: x, type: slide}]}
uncertain: [{stiffness: rho}]
)";

std::string pushes_and_pulls() {
  std::string plan = "cycle,step,fz\n";
  int step = 0;
  for (const int f : {0, 100, 200, 100, 0, -100, -200, -100, 0})
    plan += fmt::format("1,{},{}\n", ++step, f);
  return plan;
}

Comparison compared(const vjm::Robot& robot, const Campaign& campaign) {
  common::Progress silent;
  return compare(robot, campaign, 1, silent);
}

std::optional<std::vector<JointCurvePoint>> curve(const test::Laboratory& laboratory,
                                                  const Campaign& campaign,
                                                  const vjm::Robot& with) {
  const Comparison before = compared(laboratory.robot(), campaign);
  common::Progress silent;
  return joint_curve(laboratory.robot(), with, campaign, before.noise, before.nominal,
                     compared(with, campaign).nominal, {0, "rho"}, 1, silent);
}

// One joint along the reading: what is read is its deflection, and the load is what is stated.
TEST(JointCurve, OfOneJointIsItsReadings) {
  test::Laboratory laboratory(slide);
  laboratory.hide("clearance", "x.rho", "gap=5 um");
  const Campaign campaign = laboratory.measure(pushes_and_pulls());
  vjm::Robot with = laboratory.robot();
  with.bare = with.manipulator;
  with.effects = {vjm::effect_from_words("clearance", "x.rho", "gap=5 um", with.kinds(),
                                         with.without_effects(), with.units)};
  const auto points = curve(laboratory, campaign, with);
  ASSERT_TRUE(points.has_value());
  ASSERT_EQ(points->size(), campaign.readings.size());
  for (const JointCurvePoint& p : *points) {
    const Reading& reading = campaign.readings[p.reading];
    const double force = reading.load.force.z();
    EXPECT_NEAR(p.load, force, 1e-6);
    EXPECT_NEAR(p.without, force / 4e7, 1e-12);
    EXPECT_NEAR(p.spring, force / 4e7, 1e-12);
    EXPECT_NEAR(p.measured, reading.displacement.z(), 1e-12);
    EXPECT_NEAR(p.deviation, reading.sigma.z(), 1e-12);
    // The spring bears what is left of the deflection beyond a gap with corners rounded over a
    // fifth of it.
    constexpr double gap = 5e-6, corner = gap / 5;
    const double borne =
        p.with + (std::hypot(p.with - gap, corner) - std::hypot(p.with + gap, corner)) / 2;
    EXPECT_NEAR(4e7 * borne, force, 1e-6);
  }
}

// Two models that predict the same are one curve.
TEST(JointCurve, OfTwoModelsThatAreOneIsOneCurve) {
  test::Laboratory laboratory(slide);
  const Campaign campaign = laboratory.measure(pushes_and_pulls());
  const auto points = curve(laboratory, campaign, laboratory.robot());
  ASSERT_TRUE(points.has_value());
  for (const JointCurvePoint& p : *points) EXPECT_NEAR(p.with, p.without, 1e-15);
}

TEST(JointCurve, NeedsAJointWithASpringOfItsOwnAndNoEffectYet) {
  test::Laboratory laboratory(slide);
  const Campaign campaign = laboratory.measure(pushes_and_pulls());
  const Comparison before = compared(laboratory.robot(), campaign);
  common::Progress silent;
  const auto at = [&](const vjm::Robot& robot, const vjm::EffectSite& site) {
    return joint_curve(robot, robot, campaign, before.noise, before.nominal, before.nominal, site,
                       1, silent);
  };
  EXPECT_FALSE(at(laboratory.robot(), {0, "none"}));
  EXPECT_FALSE(at(laboratory.robot(), {1, "rho"}));
  vjm::Robot with = laboratory.robot();
  with.bare = with.manipulator;
  with.effects = {vjm::effect_from_words("clearance", "x.rho", "gap=5 um", with.kinds(),
                                         with.without_effects(), with.units)};
  EXPECT_FALSE(at(with, {0, "rho"}));
}

}  // namespace
}  // namespace kinetostat::calibration::joint_curve_test
