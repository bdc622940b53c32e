// A gauge that lags behind and a joint with friction both make loops: which of them it is.
#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/load_history.h"

#include "calibration/two_links.h"

namespace kinetostat::calibration::gauge_play_test {
namespace {

using test::Laboratory;
using Bench = test::TwoLinks;

// Pushed and pulled along x and y at some postures.
std::string pushes(const std::vector<std::pair<double, double>>& postures) {
  std::string csv = "id,cycle,step,q1,q2,fx,fy\n";
  int row = 0, cycle = 0;
  for (const auto& [q1, q2] : postures)
    for (const bool along_x : {true, false}) {
      ++cycle;
      int step = 0;
      for (const double f : {0, 40, 80, 120, 80, 40, 0, -40, -80, -120, -80, -40, 0})
        csv += fmt::format("r{},c{},{},{},{},{},{}\n", row++, cycle, step++, q1, q2,
                           along_x ? f : 0.0, along_x ? 0.0 : f);
    }
  return csv;
}

const std::vector<std::pair<double, double>> three_postures = {
    {0.2, 1.2}, {-0.6, 0.7}, {0.9, -1.4}};

// The readings of a gauge with play: by the sharp play operator, not by the product's model.
Campaign through_play(Campaign campaign, Eigen::Index component, double gap) {
  for (const Cycle& cycle : cycles_as_run(campaign)) {
    double follower = 0;
    for (const std::size_t r : cycle) {
      double& read = campaign.readings[r].displacement[component];
      follower = std::clamp(follower, read - gap, read + gap);
      read = follower;
    }
  }
  return campaign;
}

std::string best_of(const Diagnosis& d) {
  return d.found.empty() ? "nothing" : d.found[0].candidate.effect.kind->name;
}

class EitherLoop : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, EitherLoop, testing::Values(1, 2, 3));

TEST_P(EitherLoop, IsOfTheGaugeThatLags) {
  Bench bench(GetParam());
  const Campaign readings = bench.measure(pushes(three_postures));
  const double gap = 12e-6;
  const Diagnosis d = bench.diagnose(through_play(readings, 0, gap), {});
  EXPECT_EQ(d.verdict, Verdict::identified);
  ASSERT_EQ(best_of(d), "gauge_play");
  // The noise goes through the play of this test as well, so it is a little less sharp.
  EXPECT_NEAR(d.found[0].candidate.effect.values[0], gap, 0.1 * gap);
  EXPECT_LT(d.found[0].candidate.effect.values[1], 0.1 * gap);
}

TEST_P(EitherLoop, IsOfTheJointWithFriction) {
  for (const char* joint : {"q1", "q2"}) {
    Bench bench(GetParam());
    bench.hide("friction", joint, "force=4 N m,presliding=1e-6 rad");
    const Diagnosis d = bench.diagnose(bench.measure(pushes(three_postures)), {});
    EXPECT_EQ(d.verdict, Verdict::identified);
    ASSERT_EQ(best_of(d), "friction");
    EXPECT_EQ(d.found[0].candidate.effect.at, std::string("arm.") + joint);
    EXPECT_EQ(d.found.size(), 1u);
  }
}

TEST_P(EitherLoop, IsNoneWhereAJointHasPlayOrNothingIsHidden) {
  Bench play(GetParam());
  play.hide("clearance", "q2", "gap=1e-4 rad");
  const Diagnosis d = play.diagnose(play.measure(pushes(three_postures)), {});
  EXPECT_EQ(best_of(d), "clearance");
  EXPECT_EQ(d.found.size(), 1u);
  Bench plain(GetParam());
  EXPECT_EQ(plain.diagnose(plain.measure(pushes(three_postures)), {}).verdict,
            Verdict::none_needed);
}

// One posture and two directions are enough: friction takes part of each.
TEST(GaugePlay, IsFoundAtOnePosture) {
  Bench bench(7);
  const Campaign readings = bench.measure(pushes({{0.2, 1.2}}));
  EXPECT_EQ(best_of(bench.diagnose(through_play(readings, 0, 12e-6), {})), "gauge_play");
}

// One joint, one line: friction and play are the same there, and the diagnosis says so.
TEST(GaugePlay, IsNotTriedWhereItCannotBeTold) {
  Laboratory bench(
      "kinetostat: 1\nname: shaft\nunits: {length: m, force: N, angle: rad}\n"
      "chain_types:\n  shaft: [{actuator: {name: q, axis: Rz, stiffness: 1e5 N m/rad}}]\n"
      "manipulator: {chains: [{name: arm, type: shaft}]}\nuncertain: [{stiffness: q}]\n");
  bench.options().components = {false, false, false, false, false, true};
  bench.options().rotation_noise = 2e-5;
  std::string csv = "cycle,step,mz\n";
  for (const char* cycle : {"1", "2"}) {
    int step = 0;
    for (const double m : {0, 75, 150, 75, 0, -75, -150, -75, 0})
      csv += fmt::format("{},{},{}\n", cycle, step++, m);
  }
  bench.hide("friction", "q", "force=15 N m,presliding=0 rad");
  const Diagnosis d = bench.diagnose(bench.measure(csv), {});
  EXPECT_EQ(best_of(d), "friction");
  const auto said =
      std::find_if(d.without_place.begin(), d.without_place.end(),
                   [](const KindWithoutPlace& kind) { return kind.name == "gauge_play"; });
  ASSERT_NE(said, d.without_place.end());
  EXPECT_NE(said->reason.find("friction"), std::string::npos);
}

}  // namespace
}  // namespace kinetostat::calibration::gauge_play_test
