#include "kinetostat/calibration/campaign/campaign_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/campaign/campaign_file.h"
#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/campaign/replicates.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::campaign_check_test {
namespace {

using testing::HasSubstr;

Campaign campaign(const std::string& csv, const std::string& more = "",
                  const std::string& displacement = "difference") {
  return read_campaign(
      test::write_campaign("kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N, time: s}\n"
                           "displacement: " +
                               displacement + "\nreadings: readings.csv\n" + more,
                           csv),
      test::bench().manipulator);
}

Observability topic(const Campaign& c, const std::string& name) {
  for (const Observability& item : check_campaign(c, test::bench()))
    if (item.topic == name) return item;
  ADD_FAILURE() << "no topic " << name;
  return {};
}

// One reading tells next to nothing, and that is said.
TEST(CampaignCheck, OneReadingShowsNothing) {
  const Campaign c = campaign("fz,dz\n1000,1\n");
  for (const Observability& item : check_campaign(c, test::bench()))
    EXPECT_FALSE(item.observable) << item.topic << ": " << item.sentence;
}

struct Shows {
  std::string topic, csv, more = {}, displacement = "difference";
};

class CampaignCheckTopic : public testing::TestWithParam<Shows> {};

TEST_P(CampaignCheckTopic, ShowsWithTheseReadings) {
  const Campaign c = campaign(GetParam().csv, GetParam().more, GetParam().displacement);
  const Observability item = topic(c, GetParam().topic);
  EXPECT_TRUE(item.observable) << item.sentence;
}

INSTANTIATE_TEST_SUITE_P(
    All, CampaignCheckTopic,
    testing::Values(Shows{"noise", "fz,dz\n1,1\n1,1.1\n"},
                    Shows{"noise", "fz,dz\n1,1\n2,2\n", "noise: {translation: 1 um}\n"},
                    Shows{"offsets", "fz,dz\n1,1\n", "", "absolute"},
                    Shows{"poses", "spring,fz,dz\n0,1,1\n5,1,1\n"},
                    Shows{"nonlinearity", "fz,dz\n1,1\n2,2\n3,3\n"},
                    Shows{"reversal", "fz,dz\n1,1\n-1,-1\n"},
                    Shows{"hysteresis", "fz,direction,dz\n1,loading,1\n1,unloading,2\n"},
                    Shows{"hysteresis", "cycle,step,fz,dz\na,1,1,1\na,2,2,2\na,3,1,1\n"},
                    Shows{"clearance_or_friction",
                          "cycle,step,fz,dz\na,1,1,1\na,2,2,2\na,3,1,1\nb,1,-1,-1\n"},
                    Shows{"return_to_zero", "cycle,step,fz,dz\na,1,0,0\na,2,2,2\na,3,0,0.1\n"},
                    Shows{"sessions", "session,fz,dz\na,1,1\nb,1,1\n"},
                    Shows{"time", "time,fz,dz\n1,1,1\n2,1,1\n"},
                    Shows{"temperature", "temperature,fz,dz\n20,1,1\n21,1,1\n"},
                    Shows{"roles", "fz,role,dz\n1,,1\n2,confirm,1\n"},
                    Shows{"parameters", "fz,dz\n1,1\n2,1\n"}),
    [](const auto& shows) { return shows.param.topic + std::to_string(shows.index); });

// What is masked shows nothing.
TEST(CampaignCheck, MaskedReadingsDoNotCount) {
  const Campaign c = campaign("fz,dz,mask,mask_reason\n1,1,,\n-1,-1,1,slipped\n");
  EXPECT_FALSE(topic(c, "reversal").observable);
}

TEST(CampaignCheck, DifferencesHideOffsetsAndThatIsSaid) {
  EXPECT_THAT(topic(campaign("fz,dz\n1,1\n"), "offsets").sentence,
              HasSubstr("Gravity, geometric errors and thermal offsets are not observable"));
}

TEST(CampaignCheck, UnknownFramesOfSessionsHideThePlaceOfTheRobot) {
  const auto sentence = [](const char* displacement) {
    return topic(campaign("fz,dz\n1,1\n", "session_frame: estimate\n", displacement),
                 "session_frames")
        .sentence;
  };
  EXPECT_THAT(sentence("absolute"), HasSubstr("has an unknown frame of its own"));
  EXPECT_THAT(sentence("difference"), HasSubstr("it cancels in differences"));
}

TEST(CampaignCheck, SpanOfLoads) {
  EXPECT_THAT(topic(campaign("fx,fz,dz\n1,0,1\n0,1,1\n1,1,1\n"), "load_directions").sentence,
              HasSubstr("2 of 6 independent directions"));
}

TEST(LoadHistory, BranchesFollowTheOrderOfSteps) {
  const Campaign c = campaign("cycle,step,fz,dz\na,3,1,1\na,1,1,1\na,2,2,2\nb,1,5,1\n");
  using enum LoadDirection;
  EXPECT_THAT(branches(c), testing::ElementsAre(unloading, unstated, loading, unstated));
}

// A table may state the branch of a reading that is masked.
TEST(LoadHistory, MaskedUnloadingTakesNoLoadBack) {
  const std::string up_and_down = "fz,direction,dz,mask,mask_reason\n1,loading,1,,\n";
  EXPECT_FALSE(takes_loads_back(campaign(up_and_down + "0.5,unloading,1,1,slipped\n")));
  EXPECT_TRUE(takes_loads_back(campaign(up_and_down + "0.5,unloading,1,,\n")));
}

TEST(LoadHistory, PairsEqualAndOppositeLoadsOnce) {
  const Campaign c = campaign("fz,dz\n1,1\n-1,-1\n-1,-1\n2,2\n-2.1,2\n");
  EXPECT_EQ(reversed_pairs(c).size(), 1u);
}

TEST(LoadHistory, LevelDoesNotDependOnThePointOfTheWrench) {
  EXPECT_DOUBLE_EQ(level_of({{3, 4, 0}, {100, 0, 0}, {1, 2, 3}}), 5);
  EXPECT_DOUBLE_EQ(level_of({{0, 0, 0}, {0, 2, 0}}), 2);
}

// A weight that hangs on all readings changes nothing that follows from the loads.
TEST(LoadHistory, IsToldFromWhatChanges) {
  const std::string moments[] = {"0", "50", "100", "50", "0", "-50", "-100", "-50", "0"};
  const auto with = [&](const std::string& weight) {
    std::string csv = "cycle,step,fz,mx,dz\n";
    for (int cycle = 0; cycle < 2; ++cycle)
      for (int step = 0; step < 9; ++step)
        csv += std::to_string(cycle) + "," + std::to_string(step) + "," + weight + "," +
               moments[step] + ",0." + std::to_string(step) + "\n";
    return campaign(csv, "wrench_point: reference\n");
  };
  const Campaign bare = with("0"), loaded = with("-424");
  EXPECT_EQ(branches(loaded), branches(bare));
  EXPECT_EQ(reversed_pairs(loaded), reversed_pairs(bare));
  EXPECT_EQ(replicate_groups(loaded).size(), replicate_groups(bare).size());
  for (const char* name : {"reversal", "hysteresis", "clearance_or_friction", "return_to_zero"})
    EXPECT_TRUE(topic(loaded, name).observable) << topic(loaded, name).sentence;
  // The same weight along the force that changes: cycles start with it.
  const Campaign along = campaign(
      "cycle,step,fz,dz\na,1,-14,0\na,2,36,1\na,3,86,2\na,4,36,1\na,5,-14,0\na,6,-64,-1\n"
      "a,7,-114,-2\na,8,-64,-1\na,9,-14,0\n");
  EXPECT_EQ(reversed_pairs(along).size(), 3u);
  EXPECT_EQ(branches(along)[1], LoadDirection::loading);
  EXPECT_EQ(branches(along)[6], LoadDirection::loading);
}

// Zero offsets of sessions are unknowns, too.
TEST(CampaignCheck, CountsTheUnknownsOfSessions) {
  const std::string csv = "session,fz,dz\na,100,0.1\nb,200,0.2\nc,300,0.3\n";
  EXPECT_TRUE(topic(campaign(csv), "parameters").observable);
  const Observability item = topic(campaign(csv, "zero: estimate\n"), "parameters");
  EXPECT_FALSE(item.observable);
  EXPECT_THAT(item.sentence, HasSubstr("3 unknowns of sessions"));
}

// Loads as a cell reads them are reversed, held and back at zero although no two are equal.
TEST(CampaignCheck, KnowsLoadsThatACellHasRead) {
  const Campaign c = campaign(
      "cycle,step,fx,fz,dz\na,1,0.2,0.4,0\na,2,-0.1,500.3,0.5\na,3,0.3,999.1,1\n"
      "a,4,0.1,501.2,0.5\na,5,0,-0.3,0\na,6,0.4,-500.9,-0.5\na,7,0,-1001.5,-1\n"
      "a,8,0.2,-498.8,-0.5\na,9,0.1,0.2,0\n");
  for (const char* name :
       {"reversal", "hysteresis", "clearance_or_friction", "return_to_zero", "nonlinearity"})
    EXPECT_TRUE(topic(c, name).observable) << topic(c, name).sentence;
  EXPECT_THAT(topic(c, "load_directions").sentence, HasSubstr("1 of 6"));
  EXPECT_EQ(reversed_pairs(c).size(), 3u);
}

}  // namespace
}  // namespace kinetostat::calibration::campaign_check_test
