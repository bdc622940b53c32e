#include "kinetostat/calibration/regression/reading_offsets.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/spatial/rotation.h"

#include "calibration/synthetic.h"
#include "calibration/two_links.h"
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
  const auto of = added(effect("target_slip", {2, 180, 0, 0}), two_sessions());
  for (std::size_t r = 0; r < of.size(); ++r) {
    EXPECT_NEAR(of[r].first, r >= 11 ? 5 : 0, 1e-9) << r;
    EXPECT_NEAR(of[r].second, r >= 11 ? 1 : 0, 1e-12) << r;
  }
}

TEST(ReadingOffsets, AreOfTheRestOfACycle) {
  const auto of = added(effect("target_slip", {1, 300, 0, 2}), two_sessions());
  for (std::size_t r = 0; r < of.size(); ++r)
    EXPECT_NEAR(of[r].first, r >= 5 && r < 8 ? 5 : 0, 1e-9) << r;
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
  for (const vjm::Effect& one :
       {effect("target_slip", {2, 180, 0, 0}), effect("cycle_offset", {2})}) {
    const auto there = added(one, two_sessions());
    auto back = added(one, turned);
    std::reverse(back.begin(), back.end());
    EXPECT_EQ(there, back);
  }
}

// With three readings at least on either side of a slip, and where all of a session have a time;
// between two sessions whether they have or not.
TEST(ReadingOffsets, AreTriedWhereReadingsCanTell) {
  Campaign campaign = two_sessions();
  const std::vector<vjm::Effect> slips =
      placements(effect("target_slip", {1, 1, 0, 0}), campaign, {});
  // Before the readings 3, 4 and 5 of either session, and the second, and reading 1 of each cycle
  // but the last of a session.
  ASSERT_EQ(slips.size(), 9u);
  EXPECT_EQ(slips[0].values.tail(4), Eigen::Vector4d(1, 180, 0, 0));
  EXPECT_EQ(slips[5].values.tail(4), Eigen::Vector4d(2, 300, 0, 0));
  EXPECT_EQ(slips[6].values.tail(4), Eigen::Vector4d(2, 0, 0, 0));
  EXPECT_EQ(slips[7].values.tail(4), Eigen::Vector4d(1, 60, 0, 1));
  EXPECT_EQ(slips[8].values.tail(4), Eigen::Vector4d(2, 60, 0, 3));
  campaign.readings[9].time.reset();
  EXPECT_EQ(placements(effect("target_slip", {1, 1, 0, 0}), campaign, {}).size(), 6u);
  EXPECT_EQ(placements(effect("cycle_offset", {1}), campaign, {}).size(), 4u);
  campaign.readings[0].masked = campaign.readings[1].masked = true;
  EXPECT_EQ(placements(effect("cycle_offset", {1}), campaign, {}).size(), 3u);
  campaign.readings[4].masked = campaign.readings[5].masked = true;
  EXPECT_TRUE(placements(effect("cycle_offset", {1}), campaign, {}).empty());
}

// A target that sits elsewhere on the platform: its poses from those of the one that it was, by
// matrices alone.
TEST(ReadingOffsets, OfATargetTurnWithThePlatform) {
  test::TwoLinks links(1);
  links.options().displacement = DisplacementKind::absolute;
  links.options().components.fill(true);
  links.options().rotation_noise = 1e-5;
  std::string plan = "id,session,time,q1,q2\n";
  for (int r = 0; r < 12; ++r)
    plan += fmt::format("r{0},a,{0},{1},{2}\n", r, 0.4 * r, 0.9 - 0.1 * r);
  const Campaign campaign = links.measure(plan, "target_point: [30, -20, 80]\n");
  Eigen::VectorXd values(10);
  values << 2e-4, -1e-4, 3e-4, 1e-4, 2e-4, -1e-4, 1, 5, 1, 0;
  const vjm::Manipulator& bare = links.robot().manipulator;
  const vjm::Effect slip = vjm::test::effect(bare, "target_slip", "sensor",
                                             {values.data(), values.data() + values.size()});
  common::Progress silent;
  const Predictions with =
      Predictor(bare, {slip}, campaign, 1, silent).predict({}, VectorXd(), false, silent);
  const Predictions without =
      Predictor(bare, campaign, 1, silent).predict({}, VectorXd(), false, silent);
  const spatial::Pose moved{spatial::exp_rotation(values.segment<3>(3)), values.head<3>()};
  for (std::size_t r = 0; r < campaign.readings.size(); ++r) {
    const VectorXd& before = without.displacement[r];
    const spatial::Pose pose{spatial::exp_rotation(before.tail<3>()), before.head<3>()};
    const spatial::Pose slipped = r < 5 ? pose : pose * moved;
    EXPECT_LT((with.displacement[r].head<3>() - slipped.position()).norm(), 1e-15) << r;
    const spatial::Vector3 turned = nearest_rotation_vector(
        spatial::log_rotation(slipped.rotation()), campaign.readings[r].displacement.tail<3>());
    EXPECT_LT((with.displacement[r].tail<3>() - turned).norm(), 1e-7) << r;  // to first order
  }
}

// Where the platform turns a slip may turn along or not; where it only shifts both are the same.
TEST(ReadingOffsets, TurnAlongWhereThePlatformTurns) {
  test::TwoLinks links(1);
  links.options().displacement = DisplacementKind::absolute;
  std::string turning = "id,session,time,q1,q2\n", shifting = turning;
  for (int r = 0; r < 6; ++r) {
    turning += fmt::format("r{0},a,{0},{1},0.5\n", r, 0.2 * r);
    shifting += fmt::format("r{0},a,{0},{1},{2}\n", r, 0.2 * r, 0.5 - 0.2 * r);
  }
  const auto count = [](const test::TwoLinks& lab, const Campaign& campaign) {
    common::Progress silent;
    const Predictor predictor(lab.robot().manipulator, campaign, 1, silent);
    return placements(effect("target_slip", {1, 1, 0, 0}), campaign, predictor.platform_axes())
        .size();
  };
  EXPECT_EQ(count(links, links.measure(turning)), 2u);
  test::TwoLinks others(1);
  others.options().displacement = DisplacementKind::absolute;
  EXPECT_EQ(count(others, others.measure(shifting)), 1u);
}

}  // namespace
}  // namespace kinetostat::calibration::reading_offsets_test
