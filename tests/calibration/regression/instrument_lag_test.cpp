#include "kinetostat/calibration/regression/instrument_lag.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "kinetostat/calibration/regression/predict.h"

#include "calibration/synthetic.h"
#include "vjm/effect_catalogue.h"

namespace kinetostat::calibration::instrument_lag_test {
namespace {

using Eigen::VectorXd;

// A spring along z that is pushed, in one cycle: um is what it moves in um.
Campaign pushed(const std::vector<double>& um, const std::string& more = "",
                const std::string& displacement = "difference") {
  std::string csv = "cycle,step,fz,dz\n";
  for (std::size_t k = 0; k < um.size(); ++k) csv += fmt::format("a,{},{},0\n", k, um[k]);
  return read_campaign(
      test::write_campaign("kinetostat: 1\ncampaign: pushed\nrobot: bench.yaml\n"
                           "units: {length: um, force: N, angle: rad}\ndisplacement: " +
                               displacement +
                               "\nwrench_point: reference\nnoise: {translation: 1 um, rotation: 1 "
                               "rad}\nreadings: readings.csv\n" +
                               more,
                           csv),
      test::bench().manipulator);
}

vjm::Effect play(const vjm::Manipulator& manipulator, double gap) {
  return vjm::test::effect(manipulator, "gauge_play", "sensor", {0, 0, gap, 0, 0, 0});
}

Predictions predicted(const Campaign& campaign, double gap) {
  common::Progress silent;
  const vjm::Robot robot = test::bench();
  return Predictor(robot.manipulator, {play(robot.manipulator, gap)}, campaign, 1, silent)
      .predict({}, VectorXd(), false, silent);
}

// [um]
std::vector<double> shown(const Campaign& campaign, double gap) {
  std::vector<double> result;
  for (const VectorXd& reading : predicted(campaign, gap).displacement)
    result.push_back(1e6 * reading[2]);
  return result;
}

// Krasnosel'skii's play operator, with sharp corners.
std::vector<double> played(const std::vector<double>& there, double gap) {
  std::vector<double> result;
  double follower = 0;
  for (const double u : there) result.push_back(follower = std::clamp(follower, u - gap, u + gap));
  return result;
}

// Steps that end well inside the gap or well beyond its ends, where nothing is rounded.
const std::vector<double> path = {0, 100, 150, 145, 60, 0, -90, -86, -120, -60, 3};

TEST(InstrumentLag, IsThePlayOperator) {
  const std::vector<double> seen = shown(pushed(path), 10e-6), expected = played(path, 10);
  for (std::size_t k = 0; k < path.size(); ++k) EXPECT_NEAR(seen[k], expected[k], 1e-9) << k;
}

// Readings between, on a way that does not turn round, change nothing; masked ones carry it on.
TEST(InstrumentLag, DependsOnWhereTheLoadTurnedOnly) {
  const std::vector<double> turns = {0, 120, -80, 50};
  const std::vector<double> fine = {0, 30, 70, 120, 90, 40, -20, -80, -50, -10, 50};
  const std::vector<double> coarse_shows = shown(pushed(turns), 8e-6),
                            fine_shows = shown(pushed(fine), 8e-6);
  EXPECT_NEAR(coarse_shows[1], fine_shows[3], 1e-9);
  EXPECT_NEAR(coarse_shows[2], fine_shows[7], 1e-9);
  EXPECT_NEAR(coarse_shows[3], fine_shows[10], 1e-9);
  Campaign masked = pushed(turns);
  masked.readings[1].masked = true;
  EXPECT_NEAR(shown(masked, 8e-6)[2], coarse_shows[2], 1e-9);
}

TEST(InstrumentLag, StartsAnewInEachCycle) {
  Campaign campaign = pushed({0, 100, 50, 0, 100, 50});
  for (std::size_t r = 3; r < 6; ++r) campaign.readings[r].cycle = "b";
  const std::vector<double> seen = shown(campaign, 10e-6);
  for (std::size_t r = 0; r < 3; ++r) EXPECT_DOUBLE_EQ(seen[r], seen[r + 3]);
  campaign.history_continues = true;
  EXPECT_NEAR(shown(campaign, 10e-6)[3], 10, 1e-9);  // as it came back
}

TEST(InstrumentLag, StartsAtTheFirstReadingInPoses) {
  const std::vector<double> seen = shown(pushed({100, 150, 60}, "", "absolute"), 10e-6);
  EXPECT_NEAR(seen[0], 100, 1e-6);
  EXPECT_NEAR(seen[1], 140, 1e-6);
  EXPECT_NEAR(seen[2], 70, 1e-6);
}

// By the gap and by the stiffness, rounded corners included, against central differences.
TEST(InstrumentLag, HasExactDerivatives) {
  kinetostat::test::Random random(5);
  common::Progress silent;
  const vjm::Robot robot = test::bench();
  for (int number = 0; number < 20; ++number) {
    std::vector<double> loads = {0};
    for (int k = 0; k < 12; ++k) loads.push_back(loads.back() + random.uniform(-30, 30));
    const Campaign campaign = pushed(loads);
    const std::vector<vjm::Effect> effects = {play(robot.manipulator, 10e-6)};
    std::vector<Parameter> parameters = uncertain_parameters(robot);
    parameters.push_back(effect_parameter(effects, 0, 2, robot.manipulator));
    const Predictor predictor(robot.manipulator, effects, campaign, 1, silent);
    const auto at = [&](double log_stiffness, double gap) {
      return predictor.predict(parameters, Eigen::Vector2d(log_stiffness, gap), true, silent);
    };
    const Predictions exact = at(0.1, 10e-6);
    const double h[] = {1e-5, 1e-10};
    for (const Eigen::Index p : {0, 1}) {
      const auto shifted = [&](double s) {
        return at(0.1 + (p == 0 ? s * h[0] : 0), 10e-6 + (p == 1 ? s * h[1] : 0)).displacement;
      };
      const auto a = shifted(-2), b = shifted(-1), c = shifted(1), d = shifted(2);
      for (std::size_t r = 0; r < loads.size(); ++r) {
        const double difference = (8 * (c[r][2] - b[r][2]) - (d[r][2] - a[r][2])) / (12 * h[p]);
        EXPECT_NEAR(exact.derivatives[r](2, p), difference,
                    1e-6 * std::abs(difference) + (p == 0 ? 1e-10 : 1e-5))
            << number << ", reading " << r;
      }
    }
  }
}

// Where it opens it takes twice its size off at each turn: a search starts there.
TEST(InstrumentLag, HasDerivativesAtNone) {
  common::Progress silent;
  const vjm::Robot robot = test::bench();
  const Campaign campaign = pushed(path);
  const std::vector<vjm::Effect> none = {play(robot.manipulator, 0)};
  const std::vector<Parameter> gap = {effect_parameter(none, 0, 2, robot.manipulator)};
  const Predictions exact = Predictor(robot.manipulator, none, campaign, 1, silent)
                                .predict(gap, VectorXd::Zero(1), true, silent);
  const double h = 1e-8;
  const Predictions small = predicted(campaign, h), without = predicted(campaign, 0);
  for (std::size_t r = 0; r < path.size(); ++r) {
    EXPECT_NEAR(without.displacement[r][2], 1e-6 * path[r], 1e-15);
    EXPECT_NEAR(exact.derivatives[r](2, 0),
                (small.displacement[r][2] - without.displacement[r][2]) / h, 1e-6);
  }
}

TEST(InstrumentLag, IsNotOfWhatIsSetNorOfLevelsDrivesAndCells) {
  Campaign campaign = pushed(path);
  EXPECT_TRUE(may_lag(campaign, 2));
  for (const SensorKind kind : {SensorKind::tilt, SensorKind::joint, SensorKind::load}) {
    campaign.sensors[0].kind = kind;
    EXPECT_FALSE(may_lag(campaign, 2));
  }
  campaign.sensors[0].kind = SensorKind::distance;
  EXPECT_TRUE(may_lag(campaign, 2));
  campaign.control = DisplacementControl{.set = 2, .force = 1, .to = {}, .beside = {}, .along = {}};
  EXPECT_FALSE(may_lag(campaign, 2));
  EXPECT_TRUE(may_lag(campaign, 0));
}

}  // namespace
}  // namespace kinetostat::calibration::instrument_lag_test
