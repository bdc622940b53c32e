#include "kinetostat/calibration/regression/reading_offsets.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "kinetostat/calibration/regression/predict.h"

#include "calibration/synthetic.h"
#include "vjm/effect_catalogue.h"

namespace kinetostat::calibration::reading_offsets_test {
namespace {

using Eigen::VectorXd;

// Two sessions of two cycles with four readings each, a minute apart.
Campaign two_sessions() {
  std::string csv = "session,cycle,step,time,fz,dz\n";
  for (int n = 0; n < 16; ++n)
    csv += fmt::format("{},{},{},{},{},0\n", n < 8 ? "first" : "second", "abcd"[n / 4], n,
                       1000 + 60 * n, 10 * (n % 4));
  return read_campaign(
      test::write_campaign(
          "kinetostat: 1\ncampaign: two sessions\nrobot: bench.yaml\n"
          "units: {length: um, force: N, angle: rad, time: s}\ndisplacement: difference\n"
          "wrench_point: reference\nnoise: {translation: 1 um, rotation: 1 rad}\n"
          "readings: readings.csv\n",
          csv),
      test::bench().manipulator);
}

vjm::Effect effect(const std::string& kind, std::vector<double> names) {
  std::vector<double> values = {0, 0, 5e-6, 0, 0, 0};
  values.insert(values.end(), names.begin(), names.end());
  return vjm::test::effect(test::bench().manipulator, kind, "sensor", std::move(values));
}

// What it adds to each reading [um], and its derivative by z.
std::vector<std::pair<double, double>> added(const vjm::Effect& effect, const Campaign& campaign) {
  common::Progress silent;
  const vjm::Robot robot = test::bench();
  const std::vector<Parameter> z = {effect_parameter({effect}, 0, 2, robot.manipulator)};
  const VectorXd value = VectorXd::Constant(1, effect.values[2]);
  const Predictions with =
      Predictor(robot.manipulator, {effect}, campaign, 1, silent).predict(z, value, true, silent);
  const Predictions without =
      Predictor(robot.manipulator, campaign, 1, silent).predict({}, VectorXd(), false, silent);
  std::vector<std::pair<double, double>> result;
  for (std::size_t r = 0; r < campaign.readings.size(); ++r)
    result.emplace_back(1e6 * (with.displacement[r][2] - without.displacement[r][2]),
                        with.derivatives[r](2, 0));
  return result;
}

TEST(ReadingOffsets, AreOfOneSessionFromATimeOn) {
  const auto of = added(effect("target_slip", {2, 180}), two_sessions());
  for (std::size_t r = 0; r < of.size(); ++r) {
    EXPECT_NEAR(of[r].first, r >= 11 ? 5 : 0, 1e-9) << r;
    EXPECT_NEAR(of[r].second, r >= 11 ? 1 : 0, 1e-12) << r;
  }
}

TEST(ReadingOffsets, AreOfOneCycle) {
  const auto of = added(effect("cycle_offset", {2}), two_sessions());
  for (std::size_t r = 0; r < of.size(); ++r) {
    EXPECT_NEAR(of[r].first, r >= 4 && r < 8 ? 5 : 0, 1e-9) << r;
    EXPECT_NEAR(of[r].second, r >= 4 && r < 8 ? 1 : 0, 1e-12) << r;
  }
}

// The order of the rows says nothing.
TEST(ReadingOffsets, DoNotDependOnTheOrderOfRows) {
  Campaign turned = two_sessions();
  std::reverse(turned.readings.begin(), turned.readings.end());
  for (const vjm::Effect& one : {effect("target_slip", {2, 180}), effect("cycle_offset", {2})}) {
    const auto there = added(one, two_sessions());
    auto back = added(one, turned);
    std::reverse(back.begin(), back.end());
    EXPECT_EQ(there, back);
  }
}

// With three readings at least on either side of a slip, and where all have a time.
TEST(ReadingOffsets, AreTriedWhereReadingsCanTell) {
  Campaign campaign = two_sessions();
  const std::vector<vjm::Effect> slips = placements(effect("target_slip", {1, 1}), campaign);
  ASSERT_EQ(slips.size(), 6u);  // before the readings 3, 4 and 5 of either session
  EXPECT_EQ(slips[0].values.tail(2), Eigen::Vector2d(1, 180));
  EXPECT_EQ(slips[5].values.tail(2), Eigen::Vector2d(2, 300));
  campaign.readings[9].time.reset();
  EXPECT_EQ(placements(effect("target_slip", {1, 1}), campaign).size(), 3u);
  EXPECT_EQ(placements(effect("cycle_offset", {1}), campaign).size(), 4u);
  campaign.readings[0].masked = campaign.readings[1].masked = true;
  EXPECT_EQ(placements(effect("cycle_offset", {1}), campaign).size(), 3u);
  campaign.readings[4].masked = campaign.readings[5].masked = true;
  EXPECT_TRUE(placements(effect("cycle_offset", {1}), campaign).empty());
}

}  // namespace
}  // namespace kinetostat::calibration::reading_offsets_test
