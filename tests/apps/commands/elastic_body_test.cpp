// The Orthoglide on its elastic frame, in every command that takes a robot.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::elastic_body_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string framed = "data/robots/orthoglide_frame.yaml";

std::string printed(const std::string& arguments) {
  const Outcome outcome = kinetostat(arguments);
  EXPECT_EQ(outcome.code, 0) << arguments << '\n' << outcome.err;
  return outcome.out;
}

TEST(RobotOnAnElasticFrame, NamesTheFrameWhereItYields) {
  const std::string stiffness = printed("stiffness " + framed + " --at 0,0,0 --json frame.json");
  EXPECT_THAT(stiffness, HasSubstr("elastic body frame"));
  EXPECT_THAT(stiffness, HasSubstr("clamping of corner_frame"));
  const io::Json json = io::read_json(working_folder() / "frame.json");
  EXPECT_EQ(json["posture"]["joints"]["x"]["rho"], -0.45);
  EXPECT_THAT(printed("modes " + framed + " --at 0,0,0 --modes 2"),
              HasSubstr("elastic body frame"));
}

TEST(RobotOnAnElasticFrame, IsTakenByEveryCommandOnRobots) {
  EXPECT_THAT(printed("deflect " + framed + " --wrench 0,0,-200 --html frame.html"),
              HasSubstr("the platform moves"));
  EXPECT_GT(io::read_text(working_folder() / "frame.html").size(), 100'000u);
  EXPECT_THAT(printed("map " + framed + " --grid x=-100:100:3 --index stiffness=1,0,0"),
              HasSubstr("3 poses, 3 reached"));
  EXPECT_THAT(printed("trace " + framed + " --at 0,0,0 --along 0,0,-1 --no-uncertainty"),
              HasSubstr("stable"));
  EXPECT_THAT(printed("compensate " + framed +
                      " --path data/paths/orthoglide_milling.csv -o frame.csv --no-uncertainty"),
              HasSubstr("21 compensated"));
}

TEST(RobotOnAnElasticFrame, ExplainsItsOwnReadingsWhichARigidBaseDoesNot) {
  printed("simulate " + framed +
          " --plan data/measurements/plans/orthoglide.csv --noise-translation 2um -o framed");
  const Outcome own = kinetostat("compare " + framed + " framed/campaign.yaml");
  const Outcome other = kinetostat("compare data/robots/orthoglide_fea.yaml framed/campaign.yaml");
  EXPECT_EQ(own.code, 0) << own.err;
  EXPECT_EQ(other.code, 0) << other.err;
  EXPECT_THAT(own.out, testing::Not(HasSubstr("does not explain")));
  EXPECT_THAT(other.out, HasSubstr("does not explain"));
}

TEST(RobotOnAnElasticFrame, SaysWhereAnElasticBodyCannotBeTaken) {
  const Outcome exported = kinetostat("export " + framed);
  EXPECT_EQ(exported.code, 3);
  EXPECT_THAT(exported.err, HasSubstr("only a robot of one chain"));
  const Outcome effect =
      kinetostat("simulate " + framed +
                 " --plan data/measurements/plans/orthoglide.csv --noise-translation 2um "
                 "--effect link_compliance --at frame --size factor=1.2 -o never");
  EXPECT_EQ(effect.code, 3) << effect.out;
  EXPECT_THAT(effect.err, HasSubstr("effects act on joints and links of chains"));
}

}  // namespace
}  // namespace kinetostat::elastic_body_test
