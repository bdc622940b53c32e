// First screens of the commands of measurements, and a study from its readings to its page.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::study_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string measurements = "data/measurements/";

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// The sentence first, at most 25 lines of 100 columns.
void expect_one_screen(const std::string& command, const std::string& text) {
  const std::vector<std::string> lines = lines_of(text);
  ASSERT_FALSE(lines.empty()) << command;
  EXPECT_LE(lines.size(), 25u) << command << "\n" << text;
  for (const std::string& line : lines) EXPECT_LE(line.size(), 100u) << command << "\n" << line;
  EXPECT_FALSE(lines.front().starts_with(" ")) << command << "\n" << text;
  EXPECT_FALSE(lines.front().starts_with("kinetostat")) << command << "\n" << text;
}

class OneScreen : public testing::TestWithParam<const char*> {};

TEST_P(OneScreen, HoldsTheAnswerTheNumbersAndTheNextStep) {
  const std::string campaign = fmt::format("{}{}/campaign.yaml", measurements, GetParam());
  for (const char* command : {"measure check ", "compare ", "diagnose "}) {
    const Outcome outcome = kinetostat(command + campaign);
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 5) << outcome.err;
    expect_one_screen(command + campaign, outcome.out);
    EXPECT_THAT(outcome.out, HasSubstr("\n\nNext: ")) << command << campaign;
    const Outcome all = kinetostat(command + campaign + " --verbose");
    EXPECT_GT(all.out.size(), outcome.out.size()) << command << campaign;
    EXPECT_THAT(all.out, HasSubstr(outcome.out.substr(0, 60))) << command << campaign;
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, OneScreen,
                         testing::Values("nist_load_cell", "arm_hysteresis", "arm_nothing_hidden",
                                         "arm_outside_the_catalogue", "arm_thermal_day"),
                         [](const auto& campaign) { return campaign.param; });

// Over all shipped robots: those that stand at home, and those that need no more than a pose.
TEST(OneScreenOfRobots, StiffnessAndDeflection) {
  std::size_t stand = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(working_folder() / "data" / "robots")) {
    if (entry.path().extension() != ".yaml") continue;
    const std::string robot = "data/robots/" + entry.path().filename().string();
    for (const std::string& command :
         {"stiffness " + robot, "deflect " + robot + " --wrench 3,-4,-10"}) {
      const Outcome outcome = kinetostat(command);
      if (!outcome.out.empty()) expect_one_screen(command, outcome.out);
      stand += outcome.code == 0;
    }
  }
  EXPECT_GE(stand, 12u);
}

TEST(OneScreenOfRobots, EveryOtherCommand) {
  for (const std::string command :
       {"trace data/robots/urrs_c.yaml --along -150,0,0 --segments 1 --branches",
        "assemble data/robots/orthoglide_errors.yaml --at 0,0,0",
        "map data/robots/orthoglide.yaml --grid x=-60:60:3,y=-60:60:3,z=0 --index "
        "weakest-translation --index stiffness=1,1,1",
        "compensate data/robots/orthoglide_errors.yaml --path data/paths/orthoglide_milling.csv",
        "mesh check meshes/foot.stl --unit mm", "identify meshes/block.yaml",
        "modes meshes/block.yaml", "modes data/robots/heavy_arm.yaml",
        "stiffness data/robots/gantry.yaml", "deflect data/robots/gantry.yaml --wrench 0,0,-200",
        "export data/robots/six_axis.yaml -o six_axis.xml",
        "import data/urdf/six_axis.urdf --tip flange -o imported.yaml",
        "report data/links/foot.link.json -o l.html",
        "beam meshes/foot.yaml --fea data/links/foot.link.json", "effect list"}) {
    const Outcome outcome = kinetostat(command);
    EXPECT_EQ(outcome.code, 0) << command << outcome.err;
    if (!outcome.out.empty()) expect_one_screen(command, outcome.out);
  }
}

// Every effect, and every table of readings that is shipped with a campaign file.
TEST(OneScreenOfReadings, AndOfEffects) {
  const Outcome list = kinetostat("effect list --json list.json");
  for (const io::Json& kind : io::read_json(working_folder() / "list.json")["effects"]) {
    const std::string command = "effect show " + kind["name"].get<std::string>();
    expect_one_screen(command, kinetostat(command).out);
  }
  std::size_t tables = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(working_folder() / measurements)) {
    if (entry.path().extension() != ".yaml" || entry.path().filename() == "robot.yaml") continue;
    const std::string command =
        "readings " + entry.path().lexically_relative(working_folder()).string();
    const Outcome outcome = kinetostat(command);
    EXPECT_EQ(outcome.code, 0) << command << outcome.err;
    expect_one_screen(command, outcome.out);
    ++tables;
  }
  EXPECT_GE(tables, 10u);
}

TEST(OneScreenOfHelp, IsNoWiderThanATerminal) {
  std::vector<std::string> commands{""};
  for (const std::string& line : lines_of(kinetostat("--help").out))
    if (line.starts_with("  ") && line[2] != ' ')
      commands.push_back(line.substr(2, line.find("  ", 2) - 2));
  EXPECT_GT(commands.size(), 30u);
  for (const std::string& command : commands)
    for (const std::string& line : lines_of(kinetostat(command + " --help").out))
      EXPECT_LE(line.size(), 80u) << command << ": " << line;
}

io::Json json_of(const std::string& name) { return io::read_json(working_folder() / name); }

class Study : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(working_folder() / "study");
    std::filesystem::remove_all(working_folder() / "campaign");
    std::filesystem::copy(
        std::string(KINETOSTAT_SOURCE_DIR) + "/" + measurements + "arm_hysteresis",
        working_folder() / "campaign");
  }
  static Outcome run() { return kinetostat("study campaign/campaign.yaml -o study"); }
};

TEST_F(Study, EndsInAModelThatExplainsTheReadings) {
  const Outcome outcome = run();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_one_screen("study", outcome.out);
  const io::Json study = json_of("study/study.json"), diagnosis = json_of("study/diagnosis.json");
  ASSERT_EQ(study["stations"].size(), 6u);
  const char* names[] = {"readings", "model", "fitted", "missing", "adopted", "next"};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(study["stations"][k]["name"], names[k]);
  EXPECT_EQ(study["stations"][1]["light"], "bad");
  EXPECT_EQ(study["stations"][4]["light"], "good");
  EXPECT_EQ(study["headline"], diagnosis["headline"]);
  // What the single commands say of the same files.
  ASSERT_EQ(kinetostat("diagnose campaign/campaign.yaml -q --json d.json").code, 0);
  EXPECT_EQ(json_of("d.json")["headline"], study["headline"]);
  ASSERT_EQ(
      kinetostat("compare study/calibrated.yaml campaign/campaign.yaml -q --json a.json").code, 0);
  EXPECT_EQ(json_of("a.json")["as_designed"]["error_over_noise"], study["error_as_written"]);
  // The steps are files that the commands read.
  EXPECT_EQ(kinetostat("adopt campaign/robot.yaml study/diagnosis.json -o by_hand.yaml").code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "by_hand.yaml"),
            io::read_text(working_folder() / "study/calibrated.yaml"));
  EXPECT_EQ(
      kinetostat("plan campaign/campaign.yaml --diagnosis study/diagnosis.json -o hand.csv").code,
      0);
  EXPECT_EQ(io::read_text(working_folder() / "hand.csv"),
            io::read_text(working_folder() / "study/next.csv"));
}

TEST_F(Study, GoesOnWhereItStopped) {
  ASSERT_EQ(run().code, 0);
  const std::string page = io::read_text(working_folder() / "study/study.json");
  std::filesystem::remove(working_folder() / "study/plan.json");
  std::filesystem::remove(working_folder() / "study/calibrated.yaml");
  const Outcome again = run();
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr("diagnosis.json: made of the same files before"));
  EXPECT_THAT(again.err, testing::Not(HasSubstr("plan.json: made")));
  EXPECT_THAT(again.err, testing::Not(HasSubstr("adoption.json: made")));
  EXPECT_EQ(io::read_text(working_folder() / "study/study.json"), page);
  EXPECT_TRUE(std::filesystem::exists(working_folder() / "study/calibrated.yaml"));
  // Not when a file is another.
  io::write_atomically(working_folder() / "campaign/robot.yaml",
                       io::read_text(working_folder() / "campaign/robot.yaml") + "# changed\n");
  const Outcome other = run();
  EXPECT_EQ(other.code, 0);
  EXPECT_THAT(other.err, testing::Not(HasSubstr("made of the same files before")));
}

// Nobody can say whether the model fails: no station is red, none is green, and the last one says
// what is missing.
TEST_F(Study, GoesOnWhereTheNoiseIsNotKnown) {
  io::write_atomically(working_folder() / "slide.yaml",
                       "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\n"
                       "chain_types:\n  arm:\n"
                       "    - actuator: {name: drive, axis: Tz, stiffness: 1000}\n"
                       "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: drive}\n");
  io::write_atomically(working_folder() / "unsure.yaml",
                       "kinetostat: 1\ncampaign: unsure\nrobot: slide.yaml\n"
                       "units: {length: mm, force: N, angle: deg}\ndisplacement: difference\n"
                       "readings: unsure.csv\n");
  io::write_atomically(working_folder() / "unsure.csv",
                       "drive,fz,dz\n0,100,0.104\n0,200,0.195\n0,300,0.311\n0,-100,-0.097\n"
                       "0,-200,-0.206\n0,-300,-0.302\n");
  const Outcome outcome = kinetostat("study unsure.yaml -o study");
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("Add 'noise: {translation: 3 um}' to"));
  expect_one_screen("study", outcome.out);
  const io::Json stations = json_of("study/study.json")["stations"];
  ASSERT_EQ(stations.size(), 6u);
  for (const io::Json& station : stations) EXPECT_EQ(station["light"], "open") << station;
  EXPECT_THAT(stations[5]["sentence"].get<std::string>(), HasSubstr("how exact the readings are"));
}

// The readings of a campaign with some changed.
void change_readings(const std::function<void(std::size_t row, std::vector<std::string>& cells,
                                              std::size_t dy, std::size_t dz)>& change) {
  const std::filesystem::path file = working_folder() / "campaign/readings.csv";
  std::vector<std::string> lines = lines_of(io::read_text(file));
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  const std::vector<std::string> names = cells_of(lines[0]);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  std::string text = lines[0] + "\n";
  for (std::size_t row = 1; row < lines.size(); ++row) {
    std::vector<std::string> cells = cells_of(lines[row]);
    change(row, cells, column("dy"), column("dz"));
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  io::write_atomically(file, text);
}

// One sign is wrong: nothing is adopted, and nothing is to be measured before that is set right.
TEST_F(Study, AsksToCorrectAColumn) {
  change_readings([](std::size_t, std::vector<std::string>& cells, std::size_t dy, std::size_t) {
    cells.at(dy) = fmt::format("{}", -std::stod(cells.at(dy)));
  });
  const Outcome outcome = run();
  EXPECT_THAT(outcome.out, HasSubstr("The readings lie as predicted if 'dy' is -dy"));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "study/calibrated.yaml"));
  const io::Json stations = json_of("study/study.json")["stations"];
  EXPECT_EQ(stations[3]["light"], "bad");
  EXPECT_THAT(stations[5]["sentence"].get<std::string>(), HasSubstr("correct that in the table"));
}

// Gross errors in a campaign that is right but for them: the study does not go in a circle.
TEST_F(Study, AsksToLookAtWhatWasSetAside) {
  std::filesystem::remove_all(working_folder() / "campaign");
  std::filesystem::copy(
      std::string(KINETOSTAT_SOURCE_DIR) + "/" + measurements + "arm_nothing_hidden",
      working_folder() / "campaign");
  change_readings(
      [](std::size_t row, std::vector<std::string>& cells, std::size_t, std::size_t dz) {
        if (row % 40 == 17) cells.at(dz) = fmt::format("{}", std::stod(cells.at(dz)) + 0.4);
      });
  const Outcome outcome = run();
  EXPECT_THAT(outcome.out, HasSubstr("set aside, more than 5 standard deviations"));
  const io::Json stations = json_of("study/study.json")["stations"];
  EXPECT_THAT(stations[4]["sentence"].get<std::string>(), HasSubstr("set aside"));
  EXPECT_THAT(stations[5]["sentence"].get<std::string>(), HasSubstr("mask what is wrong"));
}

TEST_F(Study, NeedsAFolder) {
  const Outcome outcome = kinetostat("study campaign/campaign.yaml");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("Give -o DIR"));
}

}  // namespace
}  // namespace kinetostat::study_test
