#include "kinetostat/calibration/campaign/replicates.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/campaign/pure_error.h"
#include "kinetostat/calibration/statistics/normal.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::replicates_test {
namespace {

Campaign campaign(const std::string& csv, const std::string& more = "") {
  return read_campaign(
      test::write_campaign("kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, time: s}\n"
                           "displacement: difference\nreadings: readings.csv\n" +
                               more,
                           csv),
      test::bench().manipulator);
}

// Sizes of the groups, largest first.
std::vector<std::size_t> sizes(const Campaign& c) {
  std::vector<std::size_t> result;
  for (const ReplicateGroup& group : replicate_groups(c)) result.push_back(group.readings.size());
  std::sort(result.rbegin(), result.rend());
  return result;
}

using Sizes = std::vector<std::size_t>;

TEST(Replicates, AreReadingsOfEqualPoseLoadDirectionAndSetting) {
  EXPECT_EQ(sizes(campaign("fz,dz\n1,1\n1,2\n2,3\n")), (Sizes{2, 1}));
  EXPECT_EQ(sizes(campaign("spring,fz,dz\n0,1,1\n5,1,2\n0,1,3\n")), (Sizes{2, 1}));
  EXPECT_EQ(sizes(campaign("fz,setting,dz\n1,a,1\n1,b,2\n1,a,3\n")), (Sizes{2, 1}));
  EXPECT_EQ(sizes(campaign("fz,direction,dz\n1,loading,1\n1,unloading,2\n")), (Sizes{1, 1}));
  // Within a cycle the order tells: hysteresis is not noise.
  EXPECT_EQ(sizes(campaign("cycle,step,fz,dz\na,1,1,1\na,2,2,2\na,3,1,1\n")), (Sizes{1, 1, 1}));
  EXPECT_EQ(sizes(campaign("fz,px,py,pz,dz\n1,0,0,0,1\n1,0,0,3,2\n")), (Sizes{1, 1}));
}

// A joint with friction stays elsewhere after a pull than after a push.
TEST(Replicates, WithoutLoadComeBackFromTheSameSide) {
  const std::string cycle = "{0},1,0,1\n{0},2,5,2\n{0},3,0,3\n{0},4,-5,4\n{0},5,0,5\n";
  const auto twice = fmt::format(fmt::runtime(cycle), "a") + fmt::format(fmt::runtime(cycle), "b");
  EXPECT_EQ(sizes(campaign("cycle,step,fz,dz\n" + fmt::format(fmt::runtime(cycle), "a"))),
            (Sizes{1, 1, 1, 1, 1}));
  EXPECT_EQ(sizes(campaign("cycle,step,fz,dz\n" + twice)), (Sizes{2, 2, 2, 2, 2}));
  // From loads of one side, whatever their size; a rest in between is a state of its own.
  EXPECT_EQ(sizes(campaign("cycle,step,fz,dz\na,1,5,1\na,2,0,2\na,3,0,2\na,4,9,3\na,5,0,2\n")),
            (Sizes{2, 1, 1, 1}));
  // An oblique load leaves a joint elsewhere than one along the axis that it is largest along.
  EXPECT_EQ(sizes(campaign("cycle,step,fx,fz,dz\na,1,0,5,1\na,2,0,0,2\nb,1,3,4,3\nb,2,0,0,4\n")),
            (Sizes{1, 1, 1, 1}));
}

// Ten states, each read eight times over a day that warms the machine; 1 um of noise.
std::string day(double drift, bool with_times) {
  Normal normal(3);
  std::string csv = with_times ? "time,temperature,fz,dz\n" : "fz,dz\n";
  for (int visit = 0; visit < 8; ++visit)
    for (int load = 1; load <= 10; ++load) {
      if (with_times) csv += fmt::format("{},{},", 3600 * visit + load, 20 + visit % 4);
      csv += fmt::format("{},{}\n", load, 0.01 * load + drift * visit + 1e-3 * normal());
    }
  return csv;
}

TEST(Replicates, FarApartInTimeAreNoneWhereSomethingDrifts) {
  EXPECT_EQ(sizes(campaign(day(0, true))), Sizes(10, 8));
  EXPECT_EQ(sizes(campaign(day(0.02, true))), Sizes(40, 2));
  EXPECT_EQ(sizes(campaign(day(0.02, false))), Sizes(10, 8));  // nothing tells when
  const Campaign drifting = campaign(day(0.003, true), "noise: {translation: 1 um}\n");
  const Noise noise = noise_of(drifting, {});
  const PureError scatter = pure_error(drifting, replicate_groups(drifting), noise);
  EXPECT_EQ(scatter.degrees_of_freedom, 40);
  // Of neighbours: 1 um, and the 3 um of an hour between them.
  EXPECT_LT(scatter.sum / 40, 1 + 4.5 * 1.6);
}

// Each cycle starts with the reading that the others are counted from, as instruments are zeroed:
// it repeats nothing. One that comes back to zero to the last digit does.
TEST(Replicates, TheUnloadedReadingsThatOthersAreCountedFromAreNone) {
  Normal normal(5);
  std::string csv = "cycle,step,fz,dz\n", without = csv;
  for (int cycle = 1; cycle <= 20; ++cycle) {
    csv += fmt::format("{},0,0,0\n", cycle);
    for (int step = 1; step <= 4; ++step) {
      const std::string row =
          fmt::format("{},{},{},{}\n", cycle, step, step % 4, 1e-3 * (step % 4) + 1e-3 * normal());
      csv += row;
      without += row;
    }
  }
  const auto noise = [](const std::string& text) {
    const Campaign c = campaign(text);
    return noise_of(c, replicate_groups(c)).sigma[0][2];
  };
  EXPECT_NEAR(noise(csv), noise(without), 1e-12 * noise(without));
  const std::string back =
      "cycle,step,fz,dz\n1,0,0,0\n1,1,5,1\n1,2,0,0\n2,0,0,0\n2,1,5,1\n2,2,0,0\n";
  EXPECT_EQ(sizes(campaign(back)), Sizes(2, 2));
}

TEST(Replicates, OfOneTemperatureAreRepetitions) {
  std::string csv = "time,temperature,fz,dz\n";
  Normal normal(4);
  for (int visit = 0; visit < 12; ++visit)
    csv += fmt::format("{},{},5,{}\n", visit, visit % 2 == 0 ? 20 : 30,
                       (visit % 2 == 0 ? 0 : 0.1) + 1e-3 * normal());
  const Campaign c = campaign(csv);
  EXPECT_EQ(sizes(c), Sizes(6, 2));
  EXPECT_NEAR(std::sqrt(noise_of(c, replicate_groups(c)).sigma[0][2] * 1e6), 1, 0.5);
}

// The test keeps its level: chance finds a trend in one campaign of a hundred.
TEST(Replicates, AreKeptWhereNothingDrifts) {
  int split = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Normal normal(seed);
    std::string csv = "time,fz,dz\n";
    for (int i = 0; i < 40; ++i) csv += fmt::format("{},{},{}\n", i, i % 5, normal());
    split += sizes(campaign(csv))[0] == 2;
  }
  EXPECT_LE(split, 6);
}

// Two loops of different size have their ways back apart.
TEST(Replicates, OnTheWayBackHaveTurnedAtTheSameLoad) {
  const std::string loops = "cycle,step,fz,dz\na,1,0,1\na,2,5,2\na,3,1,3\nb,1,0,1\nb,2,5,2\n";
  EXPECT_EQ(sizes(campaign(loops + "b,3,1,3\n")), (Sizes{2, 2, 2}));
  EXPECT_EQ(sizes(campaign(loops + "b,3,9,4\nb,4,1,6\n")), (Sizes{2, 2, 1, 1, 1}));
}

TEST(Replicates, NeverContainMaskedReadings) {
  EXPECT_EQ(sizes(campaign("fz,dz,mask,mask_reason\n1,1,,\n1,9,1,slipped\n1,2,,\n")), (Sizes{2}));
}

TEST(Replicates, OfDifferentSessionsCountOnlyWhenTheDatumIsKnown) {
  const std::string csv = "fz,session,dz\n1,a,1\n1,b,2\n";
  EXPECT_EQ(sizes(campaign(csv)), (Sizes{2}));
  EXPECT_EQ(sizes(campaign(csv, "zero: estimate\n")), (Sizes{1, 1}));
}

// Zero load at the start and the end of each run: the difference within a run is not pure error.
TEST(Replicates, VisitsWithinOneReplicateAreKeptApart) {
  const Campaign c = campaign(
      "fz,replicate,time,dz\n"
      "0,1,0,0.00\n1,1,1,1.0\n0,1,2,0.50\n"
      "0,2,10,0.02\n1,2,11,1.0\n0,2,12,0.52\n");
  EXPECT_EQ(sizes(c), (Sizes{2, 2, 2}));
  const Noise noise{.sigma = std::vector<Eigen::VectorXd>(6, Eigen::VectorXd::Constant(6, 1e-3))};
  const PureError scatter = pure_error(c, replicate_groups(c), noise);
  EXPECT_EQ(scatter.degrees_of_freedom, 3);
  EXPECT_NEAR(scatter.sum, 2 * 2 * 0.01 * 0.01, 1e-12);
}

TEST(Replicates, PureErrorIsWeightedByTheNoiseOfEachReading) {
  const Campaign c = campaign("fz,dz\n1,1\n1,4\n");
  const Noise noise{
      .sigma = {Eigen::VectorXd::Constant(6, 1e-3), Eigen::VectorXd::Constant(6, 2e-3)}};
  // Difference 3 mm with variance 1 + 4 mm^2.
  EXPECT_NEAR(pure_error(c, replicate_groups(c), noise).sum, 9.0 / 5.0, 1e-12);
}

}  // namespace
}  // namespace kinetostat::calibration::replicates_test
