// --set KEY=VALUE, as users meet it: as if the file said so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::set_test {
namespace {

using test::kinetostat;
using test::working_folder;
using testing::HasSubstr;

io::Json unloaded(const std::string& arguments) {
  const test::Outcome outcome = kinetostat("stiffness " + arguments + " -q --json set.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return io::read_json(working_folder() / "set.json").at("unloaded");
}

TEST(SetOption, IsAsIfTheFileSaidSo) {
  std::string text = io::read_text(working_folder() / "data/robots/six_axis.yaml");
  const std::size_t at = text.find("stiffness:", text.find("name: q2")) + 11;
  text.replace(at, text.find(',', at) - at, "123456 N m/rad");
  io::write_atomically(working_folder() / "written.yaml", text);
  const io::Json set =
      unloaded("data/robots/six_axis.yaml --set 'chain_types.arm.q2.stiffness=123456 N m/rad'");
  EXPECT_EQ(set, unloaded("written.yaml"));
  EXPECT_NE(set, unloaded("data/robots/six_axis.yaml"));
  EXPECT_THAT(io::read_json(working_folder() / "set.json").at("command"), "stiffness");
}

TEST(SetOption, SaysInTheResultWhatWasSet) {
  const test::Outcome outcome = kinetostat(
      "stiffness data/robots/six_axis.yaml -v --set chain_types.arm.q1.stiffness=2e5 --set "
      "chain_types.arm.q2.stiffness=3e5 --json both.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::Json result = io::read_json(working_folder() / "both.json");
  EXPECT_THAT(result.at("options").at("set").get<std::string>(), HasSubstr("q2.stiffness=3e5"));
}

TEST(SetOption, NamesMistakes) {
  const auto refused = [](const std::string& change) {
    return kinetostat("stiffness data/robots/six_axis.yaml --set " + change);
  };
  const test::Outcome unknown = refused("chain_types.arm.q9.stiffness=1");
  EXPECT_EQ(unknown.code, 3);
  EXPECT_THAT(unknown.err, HasSubstr("there is no 'q9' under 'chain_types.arm'"));
  const test::Outcome added = refused("chain_types.arm.q1.stifness=1");  // the reader's own words
  EXPECT_EQ(added.code, 3);
  EXPECT_THAT(added.err, HasSubstr("Did you mean 'stiffness'?"));
  EXPECT_EQ(refused("chain_types").code, 2);
  EXPECT_EQ(refused("chain_types.arm.q1.stiffness=-1").code, 3);
}

// In a link file, and in the robot file that a campaign names.
TEST(SetOption, ReachesLinkFilesAndTheRobotOfACampaign) {
  const auto compliance = [](const std::string& options) {
    const test::Outcome outcome = kinetostat(
        "identify meshes/test_bar.yaml -q --set elements='{size: 8}' --json link.json" + options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return io::read_json(working_folder() / "link.json")["compliance"][0][0].get<double>();
  };
  const double steel = compliance("");
  EXPECT_NEAR(compliance(" --set material.E='105 GPa'") / steel, 2, 1e-6);
  const std::string compare = "compare data/measurements/arm_backlash_soft_base/campaign.yaml -q ";
  const test::Outcome as_it_is = kinetostat(compare),
                      softer = kinetostat(compare + "--set chain_types.arm.q2.stiffness=1e4");
  EXPECT_EQ(softer.code, 0) << softer.err;
  EXPECT_NE(as_it_is.out, softer.out);
}

}  // namespace
}  // namespace kinetostat::set_test
