// Effects whose law is a formula of the robot file.
#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "vjm/robot_text.h"

namespace kinetostat::vjm::user_effect_test {
namespace {

// One spring along z, 1e6 N/m, with further lines.
Robot bench(const std::string& more) {
  return robot_from(R"yaml(
kinetostat: 1
name: bench
units: {length: mm, force: N, angle: deg}
chain_types:
  cell:
    - actuator: {name: spring, axis: Tz, stiffness: 1000}
manipulator: {chain: cell}
)yaml" + more);
}

double deflection(const Robot& robot, double force, const Conditions& conditions = {}) {
  const EffectModel model(robot.without_effects(), robot.effects);
  const Response r =
      model.respond(posture_from_joints(robot.without_effects(), {}).posture,
                    {.force = {0, 0, force}}, conditions, model.at_rest(0), {}, false);
  EXPECT_TRUE(r.failure.empty()) << r.failure;
  return r.observed.position().z();
}

TEST(UserEffect, IsAForceBesideTheDrive) {
  const Robot robot = bench(R"yaml(
effect_kinds:
  cable:
    force: "a * d^3 + b * T"
    parameters:
      a: {unit: N/mm^3, between: [0, 1e9]}
      b: {unit: N/K, between: [-10, 10]}
effects: [{effect: cable, at: spring, a: 5e11 N/m^3, b: 2 N/K}]
)yaml");
  Conditions warm;
  warm.temperature = 30;
  // k d + a d^3 + b T at d = 1 mm: 1000 + 500 + 60 N.
  EXPECT_NEAR(deflection(robot, 1560, warm), 1e-3, 1e-12);
  EXPECT_NEAR(deflection(robot, 1540), 1e-3, 1e-12);  // 20 degrees where no temperature is known
}

TEST(UserEffect, IsAnOffsetOfTheDrive) {
  const Robot robot = bench(R"yaml(
effect_kinds:
  servo: {offset: "s * fz * (1 - exp(-t / 60))", parameters: {
  s : {
  unit:
    um / N, between : [ 0, 1 ]
  }}
}
effects: [{effect: servo, at: spring, s: 0.1 um/N}]
)yaml");
  Conditions late;
  late.time = 60;
  EXPECT_NEAR(deflection(robot, 500), 5e-4, 1e-15);
  EXPECT_NEAR(deflection(robot, 500, late), 5e-4 + 5e-5 * (1 - std::exp(-1)), 1e-15);
}

TEST(UserEffect, IsAComplianceInSeries) {
  const Robot robot = bench(R"yaml(
effect_kinds:
  moist:
    compliance: "c * humidity"
    covariates: [humidity]
    parameters: {c: {unit: mm/N, between: [0, 1]}}
effects: [{effect: moist, at: spring, c: 1e-5 mm/N}]
)yaml");
  Conditions wet;
  wet.covariates["humidity"] = 50;
  EXPECT_NEAR(deflection(robot, 500, wet), 500 * (1e-6 + 5e-7), 1e-15);
  EXPECT_NEAR(deflection(robot, 500), 5e-4, 1e-15);
}

TEST(UserEffect, IsExactlyDifferentiated) {
  const Robot robot = bench(R"yaml(
effect_kinds:
  drag:
    force: "a * tanh(d / w) + 0.1 * a * sin(x / w) * u"
    parameters: {a: {unit: N, between: [0, 1000]}, w: {unit: mm, between: [1e-6, 10]}}
  servo:
    offset: "s * fz * cos(u)"
    parameters: {s: {unit: um/N, between: [0, 1]}}
  soft:
    compliance: "c * (1 + T / 30)"
    parameters: {c: {unit: mm/N, between: [0, 1]}}
effects:
  - {effect: drag, at: spring, a: 80 N, w: 0.2 mm}
  - {effect: servo, at: spring, s: 0.1 um/N}
  - {effect: soft, at: spring, c: 2e-4 mm/N}
  - {effect: clearance, at: spring, gap: 0.05 mm}
)yaml");
  const EquilibriumOptions tight{.tolerance = 1e-15};
  std::vector<ModelParameter> parameters;
  for (std::size_t e = 0; e < robot.effects.size(); ++e)
    for (Eigen::Index v = 0; v < robot.effects[e].values.size(); ++v)
      parameters.push_back({{}, e, v});
  const Manipulator& m = robot.without_effects();
  const Posture posture = posture_from_joints(m, {{"spring", 3e-4}}).posture;
  for (int i = 0; i < 100; ++i) {
    const Load load{.force = {0, 0, 900 * std::sin(0.7 * i)}};
    Conditions conditions;
    conditions.temperature = 15 + i % 20;
    const auto at = [&](const std::vector<Effect>& effects, bool derivatives) {
      const EffectModel model(m, effects, tight);
      return model.respond(posture, load, conditions, model.at_rest(parameters.size()), parameters,
                           derivatives);
    };
    const Response exact = at(robot.effects, true);
    ASSERT_TRUE(exact.failure.empty()) << exact.failure;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const auto& [springs, e, v] = parameters[p];
      const double value = robot.effects[e].values[v], h = 1e-3 * (value == 0 ? 1 : value);
      const auto z = [&, e = e, v = v](double steps) {
        std::vector<Effect> shifted = robot.effects;
        shifted[e].values[v] += steps * h;
        return at(shifted, false).observed.position().z();
      };
      const double numerical = (8 * (z(1) - z(-1)) - (z(2) - z(-2))) / (12 * h);
      const double column = exact.derivatives(2, static_cast<Eigen::Index>(p));
      EXPECT_NEAR(numerical, column, 1e-6 * std::abs(column) + 1e-15 / h)
          << robot.effects[e].name_of(v) << " " << i;
    }
  }
}

void expect_refused(const std::string& kind, const std::string& says) {
  try {
    bench("effect_kinds:\n  own: " + kind + "\n");
    FAIL() << kind;
  } catch (const common::InputError& error) {
    EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
  }
}

TEST(UserEffect, IsRefusedWithTheColumnOfTheMistake) {
  expect_refused("{force: 'a * (d', parameters: {a: {between: [0, 1]}}}", "column 7");
  expect_refused("{force: 'd + humidity'}", "column 5");
  expect_refused("{force: 'd / fz'}", "not finite");
  expect_refused("{force: '3 + 4'}", "depends on nothing");
  expect_refused("{force: 'abs(d)'}", "abs");
  expect_refused("{offset: 'd'}", "column 1");  // the drive does not know the deflection
  expect_refused("{force: 'd', offset: 'u'}", "");
  expect_refused("{force: 'T * T', parameters: {T: {between: [0, 1]}}}", "already means");
  expect_refused("{force: 'a', parameters: {a: {between: [1, 0]}}}", "range");
  expect_refused("{force: 'a * d', parameters: {a: {between: [0, 5e-324]}}}", "prior");
}

}  // namespace
}  // namespace kinetostat::vjm::user_effect_test
