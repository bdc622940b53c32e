// The program as its users meet it: arguments and files in, exit code and text out.
#include <algorithm>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::program_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string orthoglide = "data/robots/orthoglide.yaml";

TEST(ProgramRun, VersionNamesPartsAndLicences) {
  const Outcome outcome = kinetostat("--version");
  EXPECT_EQ(outcome.code, 0);
  for (const char* part : {"Eigen", "CHOLMOD", "GPL", "TetGen", "AGPL", "Apache-2.0"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
}

// "mesh check", "identify", ...: as the help lists them.
std::vector<std::string> commands() {
  std::vector<std::string> names;
  std::istringstream lines(kinetostat("").out);
  const std::regex row("^  ([a-z]+(?: [a-z]+)?)  +\\S.*");
  std::smatch found;
  for (std::string line; std::getline(lines, line);)
    if (std::regex_match(line, found, row)) names.push_back(found[1]);
  return names;
}

// What follows "Example:" in the help of a command, on one line.
std::string example_of(const std::string& command) {
  const std::string help = kinetostat(command + " --help").out;
  const std::size_t at = help.find("Example:\n  kinetostat ");
  if (at == std::string::npos) return {};
  std::string text = help.substr(at + 22);
  for (std::size_t turn = text.find("\\\n"); turn != std::string::npos; turn = text.find("\\\n"))
    text.replace(turn, 2, "");
  return text.substr(0, text.find('\n'));
}

TEST(ProgramRun, ExampleOfEveryCommandWorks) {
  const std::string parts = kinetostat("--version").out;
  const bool without_pages = parts.find("Plotly                   not built") != std::string::npos;
  int examples = 0;
  for (const std::string& command : commands()) {
    // They have tests of their own; a studio stays until it is stopped.
    if (command == "demo" || command == "studio") continue;
    if (command == "report" && without_pages) continue;
    const std::string arguments = example_of(command);
    ASSERT_FALSE(arguments.empty()) << command;
    const Outcome outcome = kinetostat(arguments);
    EXPECT_EQ(outcome.code, 0) << arguments << '\n' << outcome.err;
    ++examples;
  }
  EXPECT_GT(examples, 20);
}

TEST(ProgramRun, MeshCheckReportsAnOpenSurfaceAndRefusesIt) {
  std::ofstream(working_folder() / "open.stl")
      << "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
         "endloop\nendfacet\nendsolid s\n";
  const Outcome outcome = kinetostat("mesh check open.stl --unit mm --json open.json");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("does not bound a solid"));
  EXPECT_THAT(io::read_text(working_folder() / "open.json"), HasSubstr("\"sound\": false"));
}

// Words alone: figures may change in their last digits.
std::string without_digits(const std::string& text) {
  return std::regex_replace(text, std::regex("[0-9.]+"), "#");
}

// The lines below "$ kinetostat demo" in the README, without their indent.
std::vector<std::string> quoted_in_readme() {
  std::istringstream text(io::read_text(std::string(KINETOSTAT_SOURCE_DIR) + "/README.md"));
  std::vector<std::string> lines;
  std::string line;
  while (std::getline(text, line) && line != "    $ kinetostat demo") continue;
  while (std::getline(text, line) && (line.empty() || line.starts_with("    ")))
    if (!line.empty()) lines.push_back(line.substr(4));
  return lines;
}

// From readings to a model that agrees, with what is hidden there named and sized, on one screen.
TEST(ProgramRun, DemoEndsInANameAndAModelThatAgrees) {
  const Outcome outcome = kinetostat("demo -o demo --json demo.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(outcome.out.starts_with("Backlash at joint q3")) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("the base"));
  EXPECT_LE(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 25);
  const io::Json study = io::read_json(working_folder() / "demo.json")["studies"][0]["study"];
  EXPECT_EQ(study["verdict"], "identified");
  EXPECT_LT(study["error_as_written"], 1.1);
  EXPECT_GT(study["waterfall"][0]["whitened"], 5);
  const io::Json found = io::read_json(working_folder() / "demo/arm/diagnosis.json")["found"];
  ASSERT_EQ(found.size(), 2u);
  const auto expect_near = [](const io::Json& effect, std::size_t k, double truth) {
    const double value = effect["values"][k], deviation = effect["deviations"][k];
    EXPECT_NEAR(value, truth, 3 * deviation) << effect["effect"];
  };
  expect_near(found[0], 0, 5.7e-5);
  expect_near(found[1], 1, 9.0e-8);
  const std::vector<std::string> quoted = quoted_in_readme();
  EXPECT_GE(quoted.size(), 10u);
  for (const std::string& line : quoted)
    EXPECT_THAT(without_digits(outcome.out), HasSubstr(without_digits(line)));
}

TEST(ProgramRun, EveryStoryHasItsFiles) {
  const Outcome outcome = kinetostat("demo --list --json list.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const io::Json& story : io::read_json(working_folder() / "list.json")["stories"]) {
    EXPECT_THAT(outcome.out, HasSubstr(story["about"].get<std::string>()));
    for (const std::string file : story["files"]) {
      const bool is_robot = file.find("robots/") != std::string::npos;
      EXPECT_EQ(kinetostat((is_robot ? "stiffness " : "measure check ") + file).code, 0) << file;
    }
  }
}

TEST(ProgramRun, ShippedLinksAreWhatTheirMeshesGive) {
  for (const std::string link : {"foot", "bar"}) {
    const std::string name = link + ".link.json";
    ASSERT_EQ(kinetostat("identify meshes/" + link + ".yaml -o " + name).code, 0);
    const auto made = io::read_compliance(working_folder() / name).matrix();
    const auto shipped = io::read_compliance(working_folder() / "data/links" / name).matrix();
    EXPECT_LT((made - shipped).norm(), 1e-6 * shipped.norm()) << link;
  }
}

TEST(ProgramRun, OutputIsTheSameBytesForAnyNumberOfThreads) {
  const std::string arguments = "stiffness " + orthoglide + " --at 0,0,0 --json - --threads ";
  const Outcome one = kinetostat(arguments + "1");
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(one.out, kinetostat(arguments + "2").out);
}

TEST(ProgramRun, JsonFileAndJsonOnStandardOutputAreTheSame) {
  EXPECT_EQ(kinetostat("stiffness " + orthoglide + " --at 0,0,0 --json result.json").code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "result.json"),
            kinetostat("stiffness " + orthoglide + " --at 0,0,0 --json -").out);
}

TEST(ProgramRun, NothingOnStandardErrorWhenQuietAndDone) {
  EXPECT_EQ(kinetostat("stiffness " + orthoglide + " --at 0,0,0 --quiet").err, "");
}

TEST(ProgramRun, FullDiskIsNotSuccess) {
  EXPECT_EQ(kinetostat("stiffness " + orthoglide + " --at 0,0,0 >/dev/full").code, 3);
  EXPECT_EQ(kinetostat("stiffness " + orthoglide + " --at 0,0,0 --json /dev/full").code, 3);
}

const std::string load_cell = "data/measurements/nist_load_cell/campaign.yaml";

TEST(ProgramRun, CompareReportsThePublishedLackOfFit) {
  const Outcome outcome = kinetostat("compare data/robots/bench.yaml " + load_cell + " -v");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("lack-of-fit F = 214.7 against 2.15"));
  // The robot that the campaign names is the same one.
  const Outcome named = kinetostat("compare " + load_cell + " -v");
  EXPECT_EQ(outcome.out.substr(outcome.out.find("Campaign")),
            named.out.substr(named.out.find("Campaign")));
}

TEST(ProgramRun, CompareSaysWhenAnotherRobotIsUsedThanTheCampaignNames) {
  std::filesystem::copy_file(working_folder() / "data/robots/bench.yaml",
                             working_folder() / "other.yaml");
  const Outcome outcome = kinetostat("compare other.yaml " + load_cell + " --csv residuals.csv");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("'other.yaml' of the command line is used instead"));
  EXPECT_TRUE(std::filesystem::exists(working_folder() / "residuals.csv"));
}

TEST(ProgramRun, CompareEndsWithFiveWhenTheReadingsAreInconclusive) {
  io::write_atomically(working_folder() / "unloaded.yaml",
                       "kinetostat: 1\ncampaign: c\nunits: {length: mm, force: N}\n"
                       "displacement: difference\nreadings: unloaded.csv\n");
  io::write_atomically(working_folder() / "unloaded.csv", "fz,dz\n0,0.1\n0,0.2\n");
  const Outcome outcome = kinetostat("compare data/robots/bench.yaml unloaded.yaml");
  EXPECT_EQ(outcome.code, 5);
  EXPECT_THAT(outcome.err, HasSubstr("no reading depends on the stiffness of 'spring'"));
}

// Poses in mm that are said to be in um: the refit goes astray, and both commands say why.
TEST(ProgramRun, AUnitErrorIsReportedWhereTheFitDoesNotConverge) {
  const std::filesystem::path folder = working_folder() / "wrong_unit";
  std::filesystem::remove_all(folder);
  std::filesystem::copy(std::string(KINETOSTAT_SOURCE_DIR) + "/data/measurements/six_axis_balancer",
                        folder);
  std::string campaign = io::read_text(folder / "campaign.yaml");
  const std::string unit = "length: mm";
  campaign.replace(campaign.find(unit), unit.size(), "length: um");
  io::write_atomically(folder / "campaign.yaml", campaign);
  const Outcome compared = kinetostat("compare wrong_unit/campaign.yaml");
  EXPECT_EQ(compared.code, 4) << compared.err;
  EXPECT_THAT(compared.err, HasSubstr("as of mm taken for um"));
  const Outcome diagnosed = kinetostat("diagnose wrong_unit/campaign.yaml");
  EXPECT_EQ(diagnosed.code, 4) << diagnosed.err;
  EXPECT_THAT(diagnosed.err, HasSubstr("as of mm taken for um"));
}

// One mistake, how the program ends, and what its message must name.
struct Mistake {
  const char* name;
  std::string arguments;
  int code;
  std::vector<std::string> message;
};

class ProgramMistake : public testing::TestWithParam<Mistake> {};

TEST_P(ProgramMistake, EndsWithItsCodeAndSaysWhatToDo) {
  const Outcome outcome = kinetostat(GetParam().arguments);
  EXPECT_EQ(outcome.code, GetParam().code) << outcome.err;
  for (const std::string& part : GetParam().message) EXPECT_THAT(outcome.err, HasSubstr(part));
}

INSTANTIATE_TEST_SUITE_P(
    Usage, ProgramMistake,
    testing::Values(
        Mistake{"unknown_command", "stifness", 2, {"Did you mean 'stiffness'?"}},
        Mistake{"unknown_option", "stiffness " + orthoglide + " --wrensh 1,0,0", 2, {"'--wrench'"}},
        Mistake{"missing_argument", "stiffness", 2, {"ROBOT is required"}},
        Mistake{"too_few_values", "stiffness " + orthoglide + " --at 0,0", 2, {"--at", "'0,0'"}},
        Mistake{"not_a_number", "stiffness " + orthoglide + " --at 0,0,x", 2, {"--at", "'x'"}},
        Mistake{
            "wrong_unit", "stiffness " + orthoglide + " --at '0,0,1 kg'", 2, {"'1 kg'", "length"}},
        Mistake{
            "excluded", "stiffness " + orthoglide + " --at 0,0,0 --joints a=1", 2, {"excludes"}},
        Mistake{"no_load", "deflect " + orthoglide, 2, {"--wrench", "no load is given"}},
        Mistake{"unknown_node",
                "deflect " + orthoglide + " --node-load elbow=0,0,1",
                2,
                {"--node-load", "the robot has no nodes"}},
        Mistake{"node_without_force",
                "deflect data/robots/heavy_arm.yaml --node-load elbow",
                2,
                {"'elbow' is not of the form"}},
        Mistake{"misspelt_node",
                "deflect data/robots/heavy_arm.yaml --node-load elbov=0,0,1",
                2,
                {"Did you mean 'elbow'?"}},
        Mistake{"density_without_unit",
                "mesh check meshes/foot.stl --unit mm --density 7",
                2,
                {"--density", "'7' has no unit"}},
        Mistake{"negative_density",
                "mesh check meshes/foot.stl --unit mm --density '-5 kg/m^3'",
                2,
                {"--density", "not above zero"}},
        Mistake{"unknown_unit",
                "mesh check meshes/foot.stl --unit furlong",
                2,
                {"--unit", "'furlong'", "Use mm, m or inch"}},
        Mistake{"one_file_for_two_results",
                "stiffness " + orthoglide + " --json new.out --html ./new.out",
                2,
                {"--html", "'./new.out' is named by --json too"}},
        Mistake{"one_file_for_a_table_and_a_result",
                "compare data/measurements/arm_nothing_hidden/campaign.yaml --csv a.csv -o a.csv",
                2,
                {"--out", "'a.csv' is named by --csv too"}},
        Mistake{"option_where_a_file_should_be",
                "compare data/measurements/arm_nothing_hidden/campaign.yaml --csv -q",
                2,
                {"--csv names no file: '-q' is an option", "./-q"}},
        Mistake{
            "negative_seed",
            "simulate " + orthoglide + " --plan data/measurements/plans/orthoglide.csv --seed -1",
            2,
            {"--seed", "-1"}},
        Mistake{"unknown_story", "demo ur1", 2, {"no story 'ur1'", "Did you mean 'ur10'?"}},
        Mistake{"no_threads", "stiffness " + orthoglide + " --threads 0", 2, {"--threads"}}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Input, ProgramMistake,
    testing::Values(
        Mistake{"missing_file", "stiffness nowhere.yaml", 3, {"nowhere.yaml", "No such file"}},
        Mistake{"folder", "stiffness data", 3, {"is a folder"}},
        Mistake{"folder_for_a_result",
                "stiffness nowhere.yaml --json data",
                3,
                {"data: cannot be written (Is a directory)"}},
        Mistake{"result_in_a_file",
                "stiffness nowhere.yaml --json " + orthoglide + "/result.json",
                3,
                {orthoglide + "/result.json: cannot be written (Not a directory)"}},
        Mistake{"not_a_robot", "stiffness CONTRIBUTING.md", 3, {"CONTRIBUTING.md"}},
        Mistake{
            "unreachable_pose", "stiffness " + orthoglide + " --at 5000,0,0", 4, {"cannot reach"}},
        Mistake{"campaign_without_robot",
                "compare data/robots/bench.yaml",
                3,
                {"bench.yaml", "no campaign file comes after it"}},
        Mistake{"missing_campaign",
                "compare data/robots/bench.yaml nowhere.yaml",
                3,
                {"nowhere.yaml", "No such file"}},
        Mistake{"unwritable",
                "stiffness " + orthoglide + " --at 0,0,0 --json /proc/x.json",
                3,
                {"/proc/x.json"}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace kinetostat::program_test
