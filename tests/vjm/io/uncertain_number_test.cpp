#include "kinetostat/vjm/io/uncertain_number.h"

#include <cmath>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/io/robot_file.h"

#include "support/matrix_near.h"
#include "vjm/robot_text.h"

namespace kinetostat::vjm::uncertain_number_test {
namespace {

using testing::HasSubstr;

const std::string arm = R"(kinetostat: 1
name: arm
units: {length: mm, force: N, angle: deg}
materials:
  steel: {E: 210 GPa, nu: 0.3}
links:
  upper: {beam: {length: 400, section: {tube: {outer: 60, inner: 50}}, material: steel}}
  fore: {beam: {length: 300, section: {circle: {diameter: 40}}, material: steel}}
chain_types:
  arm:
    - actuator: {name: q1, axis: Rz, stiffness: 2.0e4 N m/rad}
    - link: upper
    - actuator: {name: q2, axis: Rz, stiffness: 1.0e7, home: 45}
    - link: fore
manipulator: {chain: arm}
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string complaint(const std::string& text) {
  try {
    (void)robot_from(text);
  } catch (const common::InputError& error) {
    return error.what();
  }
  return "accepted";
}

const Spring& spring(const Robot& robot, const std::string& name, std::size_t chain = 0) {
  for (const Spring& s : robot.without_effects().chains()[chain].springs())
    if (s.name == name) return s;
  throw std::out_of_range(name);
}

double stiffness(const Robot& robot, const std::string& name, std::size_t chain = 0) {
  return spring(robot, name, chain).stiffness(0, 0);
}

// The robot with one of its sources at another value.
Robot with(const Robot& robot, const std::string& source, double value) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(robot.sources.size()));
  bool found = false;
  for (std::size_t i = 0; i < robot.sources.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = robot.sources[i].estimate;
    if (robot.sources[i].name != source) continue;
    values[static_cast<Eigen::Index>(i)] = value;
    found = true;
  }
  EXPECT_TRUE(found) << source;
  return with_values(robot, values);
}

TEST(UncertainNumber, HasAStandardDeviationInUnitsOrInPercent) {
  for (const char* sd : {"1.0e3 N m/rad", "1.0e6", "5 %"}) {
    const Robot robot = robot_from(
        replaced(arm, "2.0e4 N m/rad", std::string("{value: 2.0e4 N m/rad, sd: ") + sd + "}"));
    ASSERT_EQ(robot.sources.size(), 1u);
    EXPECT_EQ(robot.sources[0].name, "stiffness of q1");
    EXPECT_EQ(robot.sources[0].kind, SourceKind::joint);
    EXPECT_DOUBLE_EQ(robot.sources[0].value, 2e4);
    EXPECT_DOUBLE_EQ(robot.sources[0].estimate, 2e4);
    EXPECT_NEAR(robot.sources[0].deviation, 1e3, 1e-9);
    EXPECT_DOUBLE_EQ(stiffness(robot, "q1"), 2e4);
  }
}

// GUM 4.3.7: of a half width a, nothing else known, u = a / sqrt 3.
TEST(UncertainNumber, OfARangeHasThatOfARectangle) {
  const Robot robot = robot_from(replaced(arm, "outer: 60", "outer: {value: 60, plus_minus: 0.6}"));
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_EQ(robot.sources[0].name, "outer of upper");
  EXPECT_EQ(robot.sources[0].spread, Spread::rectangular);
  EXPECT_NEAR(robot.sources[0].deviation, 0.6e-3 / std::sqrt(3.0), 1e-15);
}

TEST(UncertainNumber, ChangesNothingByItself) {
  const Robot plain = robot_from(arm);
  const Robot uncertain =
      robot_from(replaced(replaced(arm, "E: 210 GPa", "E: {value: 210 GPa, sd: 3 %}"),
                          "stiffness: 1.0e7", "stiffness: {value: 1.0e7, plus_minus: 10 %}"));
  EXPECT_TRUE(plain.sources.empty());
  EXPECT_EQ(uncertain.sources.size(), 2u);
  for (const char* name : {"q1", "upper", "q2", "fore"})
    EXPECT_EQ(spring(plain, name).stiffness, spring(uncertain, name).stiffness) << name;
}

TEST(UncertainNumber, OfZeroUncertaintyIsNoSource) {
  EXPECT_TRUE(
      robot_from(replaced(arm, "E: 210 GPa", "E: {value: 210 GPa, sd: 0}")).sources.empty());
}

// With nu held, all that a beam yields is inverse to E; a material is one number wherever used.
TEST(UncertainNumber, OfAMaterialIsThatOfAllItsLinks) {
  const Robot robot = robot_from(replaced(arm, "E: 210 GPa", "E: {value: 210 GPa, sd: 3 %}"));
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_EQ(robot.sources[0].name, "E of steel");
  const Robot stiffer = with(robot, "E of steel", 420e9);
  for (const char* link : {"upper", "fore"})
    EXPECT_TRUE(test::matrix_near_relative(spring(stiffer, link).stiffness,
                                           Eigen::MatrixXd(2 * spring(robot, link).stiffness),
                                           1e-12));
  EXPECT_EQ(stiffness(stiffer, "q1"), stiffness(robot, "q1"));
}

// A mass is one number wherever its chain is used, and the density that of all links of a material.
TEST(UncertainNumber, OfAMassAndADensityMovesWeights) {
  const std::string heavy =
      replaced(replaced(arm, "nu: 0.3", "nu: 0.3, density: {value: 7850 kg/m^3, plus_minus: 1 %}"),
               "    - link: fore\n",
               "    - link: fore\n    - mass: {name: tool, mass: {value: 12 kg, sd: 0.5 kg}}\n");
  const Robot robot = robot_from(heavy);
  ASSERT_EQ(robot.sources.size(), 2u);
  EXPECT_EQ(robot.sources[0].name, "density of steel");
  EXPECT_EQ(robot.sources[1].name, "mass of tool");
  const auto weight = [](const Robot& of) {
    double sum = 0;
    for (const PointMass& mass : of.manipulator.chains()[0].masses()) sum += mass.mass;
    return sum;
  };
  EXPECT_NEAR(weight(with(robot, "mass of tool", 15)), weight(robot) + 3, 1e-9);
  EXPECT_NEAR(weight(with(robot, "density of steel", 2 * 7850)), 2 * weight(robot) - 12, 1e-9);
}

TEST(UncertainNumber, WithAnotherValueIsTheFileWithThatValue) {
  const Robot robot =
      robot_from(replaced(replaced(arm, "2.0e4 N m/rad", "{value: 2.0e4 N m/rad, sd: 10 %}"),
                          "outer: 60", "outer: {value: 60, sd: 1}"));
  Robot other = with(robot, "outer of upper", 0.062);
  const Robot written = robot_from(replaced(arm, "outer: 60", "outer: 62"));
  EXPECT_TRUE(test::matrix_near_relative(spring(other, "upper").stiffness,
                                         spring(written, "upper").stiffness, 1e-12));
  other = with(robot, "stiffness of q1", 1.5e4);
  EXPECT_DOUBLE_EQ(stiffness(other, "q1"), 1.5e4);
  EXPECT_EQ(spring(other, "upper").stiffness, spring(robot, "upper").stiffness);
}

TEST(UncertainNumber, OfATableIsOneForEachPlace) {
  const Robot robot = robot_from(
      replaced(arm, "stiffness: 1.0e7, home: 45",
               "stiffness: {at: [0, 90], is: [{value: 1.0e7, sd: 5 %}, 2.0e7]}, home: 0"));
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_DOUBLE_EQ(stiffness(with(robot, "stiffness of q2, is[0]", 3e4), "q2"), 3e4);
}

const std::string two_legs = R"(kinetostat: 1
name: two legs
units: {length: mm, force: N}
chain_types:
  leg:
    - actuator: {name: rho, axis: Tx, stiffness: NUMBER}
    - passive: {name: u, axes: [Ty, Tz, Rx, Ry, Rz]}
manipulator:
  chains:
    - {name: a, type: leg}
    - {name: b, type: leg}
)";

TEST(UncertainNumber, OfATypeIsTheSameInItsChainsUnlessEachHasItsOwn) {
  const Robot same = robot_from(replaced(two_legs, "NUMBER", "{value: 100, sd: 10}"));
  ASSERT_EQ(same.sources.size(), 1u);
  const Robot both = with(same, "stiffness of rho", 3e5);
  EXPECT_DOUBLE_EQ(stiffness(both, "rho", 0), 3e5);
  EXPECT_DOUBLE_EQ(stiffness(both, "rho", 1), 3e5);
  const Robot each = robot_from(replaced(two_legs, "NUMBER", "{value: 100, sd: 10, each: true}"));
  ASSERT_EQ(each.sources.size(), 2u);
  const Robot one = with(each, "stiffness of b.rho", 3e5);
  EXPECT_DOUBLE_EQ(stiffness(one, "rho", 0), 1e5);
  EXPECT_DOUBLE_EQ(stiffness(one, "rho", 1), 3e5);
}

TEST(UncertainNumber, ThatMakesNoSenseIsRefused) {
  const auto of_e = [](const std::string& number) {
    return complaint(replaced(arm, "E: 210 GPa", "E: " + number));
  };
  EXPECT_THAT(of_e("{value: 210 GPa, sd: -1 %}"),
              HasSubstr("sd: an uncertainty must not be negative"));
  EXPECT_THAT(of_e("{value: 210 GPa, plus_minus: 210 GPa}"), HasSubstr("to zero"));
  EXPECT_THAT(of_e("{value: 210 GPa, sd: 1 mm}"), HasSubstr("materials.steel.E.sd"));
  EXPECT_THAT(of_e("{value: 210 GPa}"), HasSubstr("plus_minus"));
  EXPECT_THAT(of_e("{value: 210 GPa, sd: 1 GPa, plus_minus: 1 GPa}"), HasSubstr("plus_minus"));
  EXPECT_THAT(of_e("{value: -210 GPa, sd: 1 GPa}"), HasSubstr("materials.steel.E.value"));
  EXPECT_THAT(of_e("{value: 210 GPa, sd: 1 GPa, each: true}"), HasSubstr("each"));
  EXPECT_THAT(of_e("{value: 210 GPa, sdd: 1 GPa}"), HasSubstr("Did you mean 'sd'"));
}

// A tube whose drawn diameters cross is none.
TEST(UncertainNumber, ValuesThatDoNotGoTogetherAreRefused) {
  const Robot robot = robot_from(replaced(arm, "outer: 60", "outer: {value: 60, sd: 5}"));
  EXPECT_THROW((void)with(robot, "outer of upper", 0.049), common::InputError);
}

// What readings have determined is the spring, whatever it was computed from.
TEST(UncertainNumber, OfASpringThatWasFittedCountsNoLonger) {
  const std::string stated =
      replaced(replaced(arm, "2.0e4 N m/rad", "{value: 2.0e4 N m/rad, sd: 20 %}"), "E: 210 GPa",
               "E: {value: 210 GPa, sd: 10 %}");
  const Robot robot = robot_from(stated +
                                 "fitted:\n  - {stiffness: q1, factor: {value: 0.9, sd: 0.01}}\n"
                                 "  - {stiffness: upper, factor: {value: 1.2, sd: 0.02}}\n");
  ASSERT_EQ(robot.sources.size(), 4u);
  EXPECT_NEAR(stiffness(with(robot, "stiffness of q1", 3e4), "q1"), 1.8e4, 1e-8);
  EXPECT_NEAR(stiffness(with(robot, "fitted stiffness of q1", 1.0), "q1"), 2e4, 1e-8);
  const Robot softer = with(robot, "E of steel", 105e9);
  EXPECT_TRUE(test::matrix_near_relative(spring(softer, "upper").stiffness,
                                         spring(robot, "upper").stiffness, 1e-12));
  EXPECT_TRUE(test::matrix_near_relative(Eigen::MatrixXd(2 * spring(softer, "fore").stiffness),
                                         spring(robot, "fore").stiffness, 1e-12));
  // Of two factors the last says what is known of both.
  const Robot twice = robot_from(stated +
                                 "fitted:\n  - {stiffness: q1, factor: {value: 0.9, sd: 0.1}}\n"
                                 "  - {stiffness: q1, factor: {value: 0.5, sd: 0.01}}\n");
  ASSERT_EQ(twice.sources.size(), 3u);
  EXPECT_NEAR(stiffness(twice, "q1"), 9e3, 1e-8);
  EXPECT_NEAR(stiffness(with(twice, "fitted stiffness of q1", 1.0), "q1"), 1.8e4, 1e-8);
  // A factor of which nothing is said leaves the uncertainty of the spring as it is.
  const Robot scaled = robot_from(stated + "fitted: [{stiffness: q1, factor: 0.9}]\n");
  EXPECT_NEAR(stiffness(with(scaled, "stiffness of q1", 3e4), "q1"), 2.7e4, 1e-8);
}

TEST(UncertainNumber, AnEffectHasItsStandardDeviations) {
  const Robot robot = robot_from(arm +
                                 "effects: [{effect: joint_compliance, at: q1, c: {value: 1.0e-5 "
                                 "rad/(N m), sd: 1.0e-6 rad/(N m)}}]\n");
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_EQ(robot.sources[0].kind, SourceKind::effect);
  const Robot other = with(robot, robot.sources[0].name, 3e-5);
  const auto& springs = other.manipulator.chains()[0].springs();
  EXPECT_NEAR(1 / springs[0].stiffness(0, 0), 1 / 2e4 + 3e-5, 1e-15);
}

TEST(UncertainNumber, CorrelationsNameTwoOfThem) {
  const std::string stated =
      replaced(replaced(arm, "2.0e4 N m/rad", "{value: 2.0e4 N m/rad, sd: 20 %}"), "E: 210 GPa",
               "E: {value: 210 GPa, sd: 10 %}");
  const auto correlated = [&](const std::string& line) {
    return stated + "correlations: [" + line + "]\n";
  };
  const Robot robot = robot_from(correlated("{of: stiffness of q1, with: {E of steel: -0.4}}"));
  Eigen::Matrix2d expected;
  expected << 1, -0.4, -0.4, 1;
  EXPECT_EQ(robot.correlation, expected);
  EXPECT_EQ(robot_from(stated).correlation, Eigen::Matrix2d::Identity());
  EXPECT_THAT(complaint(correlated("{of: stiffness of q1, with: {E of stel: -0.4}}")),
              HasSubstr("Did you mean 'E of steel'"));
  EXPECT_THAT(complaint(correlated("{of: stiffness of q1, with: {E of steel: -1.4}}")),
              HasSubstr("between -1 and 1"));
  EXPECT_THAT(complaint(correlated("{of: E of steel, with: {E of steel: 1}}")),
              HasSubstr("with itself"));
  EXPECT_THAT(complaint(arm + "correlations: [{of: a, with: {b: 0}}]\n"),
              HasSubstr("is no uncertain number of this file"));
}

TEST(UncertainNumber, CorrelationsThatExcludeEachOtherAreRefused) {
  const std::string stated =
      replaced(replaced(replaced(arm, "2.0e4 N m/rad", "{value: 2.0e4 N m/rad, sd: 20 %}"),
                        "E: 210 GPa", "E: {value: 210 GPa, sd: 10 %}"),
               "1.0e7", "{value: 1.0e7, sd: 10 %}");
  EXPECT_THAT(complaint(stated + "correlations:\n"
                                 "  - {of: stiffness of q1, with: {stiffness of q2: 0.9}}\n"
                                 "  - {of: stiffness of q1, with: {E of steel: 0.9}}\n"
                                 "  - {of: stiffness of q2, with: {E of steel: -0.9}}\n"),
              HasSubstr("impossible"));
}

// The spread that a source states is that of its quantiles: mean and variance by the midpoint rule.
TEST(UncertainNumber, QuantilesHaveTheMeanAndTheDeviation) {
  for (const Spread spread : {Spread::normal, Spread::log_normal, Spread::rectangular}) {
    const UncertaintySource source{
        .name = {}, .place = {}, .spread = spread, .estimate = 5, .deviation = 1.5};
    constexpr int count = 200000;
    double sum = 0, squares = 0;
    for (int i = 0; i < count; ++i) {
      const double x = source.quantile((i + 0.5) / count);
      sum += x;
      squares += (x - 5) * (x - 5);
    }
    EXPECT_NEAR(sum / count, 5, 1e-3) << static_cast<int>(spread);
    EXPECT_NEAR(std::sqrt(squares / count), 1.5, 2e-3) << static_cast<int>(spread);
  }
}

}  // namespace
}  // namespace kinetostat::vjm::uncertain_number_test
