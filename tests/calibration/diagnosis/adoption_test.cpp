// Effects into robot files, and out again.
#include "kinetostat/calibration/diagnosis/adoption.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::calibration::adoption_test {
namespace {

using testing::HasSubstr;

const double unknown = std::nan("");

const Adoption clearance{
    .effects = {{.effect = "clearance",
                 .at = "x.rho",
                 .values = {{"gap", "m", 0.1 + 0.2, 1e-6}, {"n", "", 3, unknown}},
                 .reasons = {"because of a: test"}}},
    .fitted = {}};

const std::string robot =
    "kinetostat: 1   # a comment\nname: r\n\n# the end\nmanipulator: {chain: c}\n";

TEST(Adoption, ChangesNothingButTheEffects) {
  const std::string with = adopted(robot, clearance);
  EXPECT_TRUE(with.starts_with(robot));
  EXPECT_THAT(with, HasSubstr("effects:\n"));
  EXPECT_THAT(with, HasSubstr("  # because of a: test\n"));
  EXPECT_THAT(with, HasSubstr("gap: {value: 0.3 m, sd: 1e-06 m}, n: 3}"));
  EXPECT_EQ(reverted(with), robot);
}

TEST(Adoption, GoesBehindTheEffectsThatAreThere) {
  const std::string text =
      "kinetostat: 1\neffects:   # found before\n  - {effect: preload, at: a}\n\n  # two\n  - "
      "{effect: preload, at: b}\n\nunits: {length: mm}\n";
  const std::string once = adopted(text, clearance);
  EXPECT_LT(once.find("at: b"), once.find("x.rho"));
  EXPECT_LT(once.find("x.rho"), once.find("units:"));
  const std::string twice = adopted(once, clearance);
  EXPECT_EQ(reverted(twice), once);
  EXPECT_EQ(reverted(once), text);
}

// The digits that are written err by less than a twentieth of a percent of the deviation.
TEST(Adoption, WritesTheDigitsThatTheDeviationAsksFor) {
  const auto written = [](double value, double deviation) {
    Adoption one = clearance;
    one.effects[0].values = {{"gap", "m", value, deviation}};
    const std::string text = adopted(robot, one);
    const std::size_t at = text.find("value: ") + 7;
    return std::stod(text.substr(at));
  };
  for (const double value : {1.23456789012, -0.000123456789012, 6.54321e7})
    for (const double relative : {1.0, 0.1, 1e-3, 1e-6, 1e-9}) {
      const double deviation = std::abs(value) * relative;
      EXPECT_LE(std::abs(written(value, deviation) - value),
                5e-4 * std::min(deviation, std::abs(value)))
          << value << " " << relative;
    }
  Adoption coarse = clearance;
  coarse.effects[0].values = {{"gap", "mm", 0.0523456789, 0.05}};
  EXPECT_THAT(adopted(robot, coarse), HasSubstr("gap: {value: 0.052346 mm, sd: 0.05 mm}"));
}

TEST(Adoption, StiffnessesGoWithTheirEffectAndComeOutWithIt) {
  Adoption whole = clearance;
  AdoptedParameter factor, value;
  factor.stiffness = "q1";
  factor.value = {"factor", "", 0.87312345, 0.0042};
  factor.remark = "was 60000, is 52390 N m/rad";
  value.effect = "hardening";
  value.at = "x.rho";
  value.parameter = "k3";
  value.value = {"value", "N/m^3", 2e12, unknown};
  whole.fitted = {factor, value};
  const std::string once = adopted(robot, whole);
  EXPECT_TRUE(once.starts_with(robot));
  EXPECT_THAT(once, HasSubstr("  - {stiffness: q1, factor: {value: 0.8731235, sd: 0.0042}}  # was "
                              "60000, is 52390 N m/rad\n"));
  EXPECT_THAT(once, HasSubstr("  - {effect: hardening, at: x.rho, parameter: k3, value: "
                              "2000000000000 N/m^3}\n"));
  const std::string twice = adopted(once, whole);
  EXPECT_EQ(reverted(twice), once);
  EXPECT_EQ(reverted(once), robot);
  // An effect alone after it leaves the stiffnesses of the first.
  EXPECT_EQ(reverted(adopted(once, clearance)), once);
}

TEST(Adoption, WritesEachCorrelationOnceAndTakesItOutAgain) {
  Adoption whole = clearance;
  whole.correlation.names = {"fitted stiffness of q1", "fitted stiffness of q2",
                             "gap of clearance at x.rho"};
  whole.correlation.matrix = Eigen::Matrix3d::Identity();
  whole.correlation.matrix(0, 1) = whole.correlation.matrix(1, 0) = -0.61849;
  whole.correlation.matrix(1, 2) = whole.correlation.matrix(2, 1) = 0.25;
  const std::string once = adopted(robot, whole);
  EXPECT_THAT(once,
              HasSubstr("  - {of: fitted stiffness of q1, with: {fitted stiffness of q2: -0.618}}\n"
                        "  - {of: fitted stiffness of q2, with: {gap of clearance at x.rho: "
                        "0.250}}\n"));
  EXPECT_EQ(reverted(once), robot);
  EXPECT_EQ(reverted(adopted(once, whole)), once);
  Adoption independent = clearance;
  independent.correlation = whole.correlation.only({"fitted stiffness of q1"});
  EXPECT_EQ(adopted(robot, independent), adopted(robot, clearance));
}

// What is estimated anew forgets what it was correlated with.
TEST(Adoption, WritesZeroWhereACorrelationIsSuperseded) {
  Adoption anew = clearance;
  anew.correlation = {.names = {"a", "b"}, .matrix = Eigen::Matrix2d::Identity()};
  anew.superseded = {{"b", "a"}, {"c", "b"}};
  EXPECT_THAT(adopted(robot, anew), HasSubstr("  - {of: a, with: {b: 0.000}}\n"
                                              "  - {of: b, with: {c: 0}}\n"));
}

TEST(Adoption, KeepsTheCorrelationsOfWhatIsAdopted) {
  EstimateCorrelation all{.names = {"a", "b", "c"}, .matrix = {}};
  all.matrix = Eigen::Matrix3d::Identity();
  all.matrix(0, 2) = all.matrix(2, 0) = 0.5;
  all.matrix(0, 1) = all.matrix(1, 0) = 0.1;
  const EstimateCorrelation part = all.only({"c", "a", "unknown"});
  EXPECT_EQ(part.names, (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(part.matrix(0, 1), 0.5);
  EXPECT_EQ(part.matrix(1, 1), 1);
}

TEST(Adoption, TakesOutWhatWasWrittenBeforeAdoptionsHadNumbers) {
  const std::string block =
      "  # >>> adopted effect\n  - {effect: preload, at: b}\n  # <<< adopted effect\n";
  const std::string heading =
      robot +
      "effects:\n  # >>> adopted effect (with the heading)\n  - {effect: preload, at: a}\n"
      "  # <<< adopted effect\n";
  EXPECT_EQ(reverted(heading + block), heading);
  EXPECT_EQ(reverted(heading), robot);
  EXPECT_EQ(reverted(adopted(heading, clearance)), heading);
}

TEST(Adoption, RefusesWhatItCannotExtendOrTakeBack) {
  EXPECT_THROW(adopted("effects: [{effect: preload, at: a}]\n", clearance), std::invalid_argument);
  EXPECT_THROW(adopted("name: x", clearance), std::invalid_argument);
  EXPECT_THROW(reverted(robot), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::calibration::adoption_test
