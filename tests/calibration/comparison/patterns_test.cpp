#include "kinetostat/calibration/comparison/patterns.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/report/comparison.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::patterns_test {
namespace {

using testing::HasSubstr;

// Readings of the bench with a known flaw: load cycles up, down and to the other side, two
// sessions, a temperature, and a column that means nothing. dz in mm, F/k = 1 um/N.
struct Flaw {
  double friction = 0;    // lag of the displacement behind the load [mm]
  double gap = 0;         // jump where the load changes sign [mm]
  double cubic = 0;       // of the displacement at 4 kN [mm]
  double drift = 0;       // of session b [mm]
  double thermal = 0;     // [mm/K]
  double compliance = 0;  // relative
  unsigned seed = 1;
};

std::string csv(const Flaw& flaw) {
  std::mt19937 engine(flaw.seed);
  std::normal_distribution<double> noise(0, 0.01);
  std::string text = "id,session,cycle,step,temperature,dummy,fz,dz\n";
  const std::vector<int> path = {0, 1, 2, 3, 4, 3, 2, 1, 0, -1, -2, -3, -4, -3, -2, -1, 0};
  int id = 0;
  for (int cycle = 0; cycle < 6; ++cycle)
    for (std::size_t s = 0; s < path.size(); ++s) {
      const double load = path[s];
      const double way = s == 0 ? 0 : load - path[s - 1];
      const double temperature = 20 + (cycle * 7 + static_cast<int>(s) * 3) % 5;
      const double sign = load > 0 ? 1 : load < 0 ? -1 : 0;
      double dz = load * (1 + flaw.compliance) - flaw.friction * way + flaw.gap * sign;
      dz += flaw.cubic * std::pow(load / 4, 3) + flaw.thermal * (temperature - 22);
      dz += cycle >= 3 ? flaw.drift : 0;
      text += fmt::format("r{},{},c{},{},{},{},{},{}\n", id, cycle < 3 ? "a" : "b", cycle, s,
                          temperature, (id * 37) % 11, 1000 * load, dz + noise(engine));
      ++id;
    }
  return text;
}

struct Compared {
  Campaign campaign;
  Comparison comparison;

  const Patterns& patterns() const { return comparison.nominal.patterns; }
  double p(const std::string& factor) const {
    for (const Pattern& pattern : patterns().factors)
      if (pattern.factor == factor) return pattern.holm_p_value();
    ADD_FAILURE() << "no factor " << factor;
    return -1;
  }
  std::string sentences() const {
    std::string all;
    for (const std::string& s : report::findings(campaign, comparison)) all += s + "\n";
    return all;
  }
};

Compared compared(const Flaw& flaw) {
  vjm::Robot robot = test::bench();
  robot.uncertain.clear();
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\nnoise: {translation: 10 um}\ndatum_noise: {translation: 0 um}\n",
      csv(flaw));
  Campaign campaign = read_campaign(file, robot.manipulator);
  common::Progress silent;
  Comparison comparison = compare(robot, campaign, 1, silent);
  return {std::move(campaign), std::move(comparison)};
}

TEST(Patterns, FrictionIsAMatterOfTheBranchAndLosesWork) {
  const Compared c = compared({.friction = 0.05});
  EXPECT_LT(c.p("branch"), 1e-6);
  EXPECT_GT(c.p("session"), 0.05);
  EXPECT_LT(c.patterns().loops.area.value().holm_p_value, 1e-6);
  ASSERT_EQ(c.patterns().loops.each.size(), 6u);
  // By the trapezoidal rule the lag turns over, 0.1 mm, half a step before +-4 kN, and sets in at
  // 0.5 kN. The noise of such an area is 0.04 J.
  EXPECT_NEAR(c.patterns().loops.each[0].measured, 0.1e-3 * 2 * 3500 - 0.05e-3 * 500, 4 * 0.04);
  EXPECT_NEAR(c.patterns().loops.each[0].predicted, 0, 1e-9);
  EXPECT_THAT(c.sentences(), HasSubstr("error depends on branch"));
  EXPECT_THAT(c.sentences(), HasSubstr("in load cycle"));
}

TEST(Patterns, ClearanceIsOddAndAMatterOfTheSignOfTheLoad) {
  const Compared c = compared({.gap = 0.05});
  EXPECT_LT(c.p("direction of load"), 1e-6);
  ASSERT_TRUE(c.patterns().reversal);
  EXPECT_GT(c.patterns().reversal->odd_share, 0.9);
  EXPECT_LT(c.patterns().reversal->test.holm_p_value, 1e-6);
  EXPECT_GT(c.p("branch"), 0.05);
}

TEST(Patterns, NonlinearityIsAMatterOfTheLevelOfLoad) {
  const Compared c = compared({.cubic = 0.1});
  EXPECT_LT(c.p("level of load"), 1e-6);
  EXPECT_THAT(c.sentences(), HasSubstr("error depends on level of load"));
}

TEST(Patterns, DriftIsAMatterOfTheSession) {
  const Compared c = compared({.drift = 0.03});
  EXPECT_LT(c.p("session"), 1e-6);
  EXPECT_EQ(c.patterns().factors.front().factor, "session");
  // The half of the values that holds nearly all the error.
  EXPECT_EQ(c.patterns().factors.front().groups.front().label, "b");
  EXPECT_GT(c.patterns().factors.front().groups.front().share, 0.8);
  EXPECT_DOUBLE_EQ(c.patterns().factors.front().groups.front().share_of_values, 0.5);
}

TEST(Patterns, ThermalErrorIsAMatterOfTheTemperature) {
  const Compared c = compared({.thermal = 0.02});
  EXPECT_EQ(c.patterns().factors.front().factor, "temperature");
  EXPECT_LT(c.p("temperature"), 1e-6);
  EXPECT_GT(c.p("dummy"), 0.05);
}

double smallest_p(const Patterns& patterns) {
  double smallest = 1;
  for (const auto* test : {&patterns.loops.area, &patterns.loops.return_to_zero})
    if (*test) smallest = std::min(smallest, (*test)->holm_p_value);
  for (const Pattern& pattern : patterns.factors)
    smallest = std::min(smallest, pattern.holm_p_value());
  if (patterns.reversal) smallest = std::min(smallest, patterns.reversal->test.holm_p_value);
  return smallest;
}

// Over many campaigns without a flaw a finding is as rare as the family-wise level says.
TEST(Patterns, SoundModelsGiveFewFalseAlarms) {
  int alarms = 0;
  constexpr int campaigns = 300;
  for (unsigned seed = 1; seed <= campaigns; ++seed) {
    const Compared c = compared({.seed = seed});
    alarms += smallest_p(c.patterns()) < 0.05;
  }
  RecordProperty("alarms", alarms);
  EXPECT_LT(alarms, 0.05 * campaigns + 4 * std::sqrt(campaigns * 0.05 * 0.95));
}

// Six axes, 12 postures, two sessions, cycles up and down to both sides, unequal groups, a
// temperature, a setting and two columns that mean nothing; as measured by an instrument with
// normal noise when the model is right.
Campaign six_axis_campaign() {
  Campaign c;
  c.units = {.length = "mm", .force = "N", .angle = "deg", .time = "s"};
  c.sessions = {"a", "b"};
  c.noise_stated = true;
  c.covariates = {{"humidity", {}}, {"operator", {}}};
  const std::vector<double> path = {0, 1, 2, 3, 2, 1, 0, -1, -2, -3, -2, -1, 0};
  for (std::size_t posture = 0; posture < 12; ++posture) {
    const auto x = static_cast<double>(posture);
    c.configurations.push_back(
        {spatial::Pose::translation({0.01 * x, 0.02 * (posture % 3), 0.05 * (posture % 5)}), {}});
    for (std::size_t step = 0; step < path.size(); ++step) {
      const std::size_t i = c.readings.size();
      Reading r;
      r.id = std::to_string(i);
      r.session = posture % 3 == 0 ? 1 : 0;
      r.step = static_cast<double>(step);
      r.cycle = fmt::format("c{}", posture);
      r.setting = i % 7 == 0 ? "high" : "low";
      r.time = 60.0 * static_cast<double>(i);
      r.temperature = 20 + static_cast<double>((i * 5) % 9);
      r.configuration = posture;
      r.load.force[static_cast<Eigen::Index>(posture % 3)] = 100 * path[step];
      r.sigma << 1e-5, 1e-5, 2e-5, 2e-5, 2e-5, 4e-5;
      r.displacement.setZero();
      c.readings.push_back(r);
      c.covariates[0].values.push_back(std::to_string((i * 37) % 101));
      c.covariates[1].values.push_back(i % 11 < 2 ? "Ann" : "Bob");
    }
  }
  return c;
}

// The same over six axes, straight from normal noise: the share of campaigns with any finding lies
// within the two-sided 99.9 % interval of the binomial law about 5 %, or below it.
TEST(Patterns, SoundModelsOfSixAxesGiveFewFalseAlarms) {
  Campaign campaign = six_axis_campaign();
  std::mt19937 engine(11);
  std::normal_distribution<double> normal(0, 1);
  constexpr int campaigns = 400;
  int alarms = 0;
  for (int n = 0; n < campaigns; ++n) {
    std::vector<Eigen::VectorXd> residual, whitened;
    std::vector<spatial::Vector6> work;
    for (Reading& reading : campaign.readings) {
      work.push_back(reading.load.at_reference_point({}));
      whitened.push_back(Eigen::VectorXd::NullaryExpr(6, [&] { return normal(engine); }));
      residual.push_back(whitened.back().cwiseProduct(reading.sigma));
      reading.displacement = residual.back();
    }
    const Noise noise = noise_of(campaign, {});
    alarms += smallest_p(find_patterns(campaign, residual, whitened, work, 0, noise)) < 0.05;
  }
  RecordProperty("alarms", alarms);
  EXPECT_LT(alarms, 0.05 * campaigns + 3.29 * std::sqrt(campaigns * 0.05 * 0.95));
}

TEST(Patterns, APerfectModelHasNone) {
  const auto file = test::write_campaign(
      "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\ndisplacement: difference\n"
      "readings: readings.csv\n",
      "fz,dz\n1000,1\n2000,2\n-1000,-1\n");
  vjm::Robot robot = test::bench();
  robot.uncertain.clear();
  const Comparison c = test::compare_files(robot, file);
  EXPECT_TRUE(c.nominal.is_exact);
  EXPECT_TRUE(c.nominal.patterns.factors.empty());
  const auto sentences = report::findings(read_campaign(file, robot.manipulator), c);
  EXPECT_THAT(sentences, testing::ElementsAre(HasSubstr("no error beyond rounding")));
}

TEST(Holm, IsTheStepDownProcedure) {
  EXPECT_THAT(holm({0.01, 0.04, 0.03, 0.005}),
              testing::Pointwise(testing::DoubleNear(1e-15), {0.03, 0.06, 0.06, 0.02}));
  EXPECT_THAT(holm({0.9, 0.8}), testing::ElementsAre(1, 1));
  EXPECT_TRUE(holm({}).empty());
}

}  // namespace
}  // namespace kinetostat::calibration::patterns_test
