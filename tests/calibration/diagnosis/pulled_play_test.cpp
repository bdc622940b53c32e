// Play in a test that sets the way and reads the force: in the gap no force acts, and readings at
// its ends show how sharp its corners are, which loads jump across.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/report/screen/diagnosis.h"

#include "calibration/laboratory.h"
#include "calibration/synthetic.h"

namespace kinetostat::calibration::pulled_play_test {
namespace {

using test::Laboratory;
using testing::HasSubstr;

constexpr double noise = 2;  // [N]

// A spring of 970 N/mm beside one of 1000 that is stated, with a gap of sharp corners [mm].
std::string pulled(double gap, int levels, std::uint64_t seed) {
  Normal normal(seed);
  std::string csv = "cycle,step,dz,fz\n";
  for (const char* cycle : {"1", "2"})
    for (int i = 0; i <= 4 * levels; ++i) {
      const int up = i <= levels ? i : i <= 3 * levels ? 2 * levels - i : i - 4 * levels;
      const double way = static_cast<double>(up) / levels;
      const double beyond = std::copysign(std::max(0., std::abs(way) - gap), way);
      csv += fmt::format("{},{},{},{}\n", cycle, i + 1, way, 970 * beyond + noise * normal());
    }
  return csv;
}

class PulledPlay : public testing::TestWithParam<std::pair<double, int>> {};
INSTANTIATE_TEST_SUITE_P(Gaps, PulledPlay,
                         testing::Values(std::pair(0.01, 6), std::pair(0.05, 20), std::pair(0.2, 6),
                                         std::pair(0.2, 20)));

TEST_P(PulledPlay, IsCalledBacklash) {
  const auto [gap, levels] = GetParam();
  const Laboratory bench(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
      "  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
      "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n");
  const Campaign campaign = read_campaign(
      test::write_campaign(fmt::format("kinetostat: 1\ncampaign: pulled\nunits: {{length: mm, "
                                       "force: N, angle: deg}}\ndisplacement: difference\n"
                                       "wrench_point: reference\ndisplacement_control: {{set: dz, "
                                       "force: fz, noise: {} N}}\nreadings: readings.csv\n",
                                       noise),
                           pulled(gap, levels, 3)),
      bench.robot().manipulator);
  const Diagnosis d = bench.diagnose(
      campaign, {"clearance", "biased_clearance", "hardening", "piecewise_stiffness", "friction"});
  EXPECT_EQ(d.verdict, Verdict::identified);
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_EQ(d.found[0].candidate.effect.at, "cell.q");
  EXPECT_THAT(d.found[0].decision.answers.at(0).effect_class, HasSubstr("backlash"));
  // By hundreds of nats where many readings lie near sharp corners of a wide gap.
  const LawShare& first = d.found[0].decision.answers[0].laws.at(0);
  if (gap > 0.1 && levels > 10) {
    EXPECT_EQ(first.effect, "piecewise_stiffness");
    EXPECT_TRUE(first.is_at_limit);
    EXPECT_EQ(d.found[0].decision.answers[0].effect_class, "backlash");
  }
  EXPECT_THAT(report::headline(bench.robot(), campaign, d),
              testing::AnyOf(HasSubstr("acklash at joint q"), HasSubstr("acklash, or"),
                             HasSubstr("or backlash"), HasSubstr("learance at joint q")));
}

}  // namespace
}  // namespace kinetostat::calibration::pulled_play_test
