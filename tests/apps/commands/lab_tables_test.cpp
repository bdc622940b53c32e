// Five tables as five laboratories would write them, each from the file as it is to its comparison:
// `readings -o` writes the campaign file, and `compare` finds in it the stiffness with which the
// table was made.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sys/resource.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"
#include "support/zip_writer.h"

namespace kinetostat::lab_tables_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

// A slide: one spring along z, nominally 1000 N/mm; the tables are made with 800 N/mm.
const std::string slide =
    "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\n"
    "chain_types: {slide: [{actuator: {name: rho, axis: Tz, stiffness: 1000}}]}\n"
    "manipulator: {chain: slide}\nuncertain: [{stiffness: rho}]\n";
constexpr double softness = 1.0 / 800;  // [mm/N]

// An arm in the plane: q1 about z, then 500 mm; nominally 1e5 N m/rad, made with 0.8e5 N m/rad.
const std::string arm =
    "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
    "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 100000 N m/rad}\n"
    "    - offset: [500, 0, 0]\n"
    "manipulator: {chain: arm}\nuncertain: [{stiffness: q1}]\n";

std::string comma(std::string text) {
  std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

// A deterministic error of the instrument [um], up to 1.
double error(int i) { return std::sin(7.0 * i * i + 1); }

struct Lab {
  std::string name, robot, file;
  std::function<std::string()> content;
  std::string options = {};  // of `readings`
};

std::string german_csv() {
  std::string text =
      "Steifigkeitspr\xfc"
      "fung Schlitten;;;\nPr\xfc"
      "fer;M\xfcller;;\n;;;\nNr.;Kraft Z [N];dz [\xb5m];Bemerkung\n";
  const double loads[] = {0, 250, 500, 750, 1000, 1250, 1500};
  for (int i = 0; i < 7; ++i)
    text += comma(fmt::format("{};{};{:.1f};{}\n", i + 1,
                              loads[i] >= 1000 ? fmt::format("1.{:03.0f}.0", loads[i] - 1000)
                                               : fmt::format("{:.1f}", loads[i]),
                              1000 * softness * loads[i] + error(i), i == 3 ? "Pause" : ""));
  // The separator of thousands stays a point: "1.250,0".
  for (std::size_t at = 0; (at = text.find(";1,", at)) != std::string::npos;) text[at + 2] = '.';
  return text;
}

std::string excel_sheet() {
  std::string rows =
      "<row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>Schlitten 3</t></is></c></row><row r=\"3\">";
  for (int c = 0; c < 3; ++c)
    rows += fmt::format("<c r=\"{}3\" t=\"s\"><v>{}</v></c>", "ABC"[c], c);
  rows += "</row>";
  for (int i = 0; i < 7; ++i)
    rows += fmt::format(
        "<row r=\"{0}\"><c r=\"A{0}\" s=\"1\"><v>{1}</v></c><c r=\"B{0}\"><v>{2}</v></c>"
        "<c r=\"C{0}\"><f>B{0}/800</f><v>{3}</v></c></row>",
        4 + i, 46145.5 + i / 8640.0, 200 * i, softness * 200 * i + 1e-3 * error(i));
  return test::xlsx_of({{"Deckblatt", ""}, {"Messung", rows}},
                       {"Zeit", "Fz [N]", "Verschiebung Z [mm]"}, {"dd/mm/yyyy hh:mm:ss"});
}

// Inches, pounds, quotes, thousands with commas.
std::string american_csv() {
  std::string text = "\"Slide stiffness, bay 4\"\nTest,\"Fz (lbf)\",dz (in)\n";
  for (int i = 0; i < 7; ++i) {
    const double pounds = 200.0 * i;
    const double inches = softness * pounds * 4.4482216152605 / 25.4 + 1e-3 / 25.4 * error(i);
    const std::string load = pounds >= 1000 ? fmt::format("\"1,{:03.0f}.0\"", pounds - 1000)
                                            : fmt::format("{:.1f}", pounds);
    text += fmt::format("{},{},{:.6f}\n", i + 1, load, inches);
  }
  return text;
}

// Absolute positions beside the angle of the joint, tabs, units in a line of their own.
std::string tracker_export() {
  std::string text =
      "SpatialTracker Export\nDate:\t2026-05-03\nInstrument:\tT3\n\nPoint\tA1\tFy\tX\tY\tZ\n"
      "\t[deg]\t[N]\t[mm]\t[mm]\t[mm]\n";
  for (int i = 0; i < 12; ++i) {
    const double angle = (10.0 * (i % 4) - 15) * M_PI / 180, force = 150.0 * (i / 4);
    double q = angle;  // of the loaded arm
    for (int k = 0; k < 50; ++k) q = angle + force * 0.5 * std::cos(q) / 0.8e5;
    text +=
        fmt::format("P{}\t{}\t{}\t{:.4f}\t{:.4f}\t0.0000\n", i, 10 * (i % 4) - 15, force,
                    500 * std::cos(q) + 1e-3 * error(i), 500 * std::sin(q) + 1e-3 * error(i + 20));
  }
  return text;
}

// One column a gauge; one of them counts downwards and was not read once.
std::string gauge_sheet() {
  std::string text = "Load [kN];Gauge 1 [um];Gauge 2 [um]\n";
  for (int i = 0; i < 7; ++i)
    text += fmt::format("{:.1f};{:.1f};{}\n", 0.2 * i, error(i),
                        i == 5 ? "n/a" : fmt::format("{:.1f}", -250 * i + error(i)));
  return text;
}

// UTF-16, ISO times at 10 Hz.
std::string logger() {
  std::string text = "Timestamp,Fz [N],dz [mm]\r\n";
  for (int i = 0; i < 600; ++i) {
    const double load = 500 + 500 * std::sin(0.05 * i);
    text += fmt::format("2026-05-03T23:59:{:02}.{}00,{:.3f},{:.6f}\r\n", i / 10 % 60, i % 10, load,
                        softness * load + 1e-3 * error(i));
  }
  std::string utf16 = "\xff\xfe";
  for (const char c : text) utf16 += std::string{c, '\0'};
  return utf16;
}

class LabTables : public testing::TestWithParam<Lab> {};

TEST_P(LabTables, GoFromTheFileToTheComparison) {
  const Lab& lab = GetParam();
  const std::filesystem::path folder = working_folder() / ("lab_" + lab.name);
  std::filesystem::create_directory(folder);
  io::write_atomically(folder / "robot.yaml", lab.robot);
  io::write_atomically(folder / lab.file, lab.content());
  const std::string at = folder.filename().string() + "/";
  const Outcome shown = kinetostat(fmt::format(
      "readings {0}{1} {0}robot.yaml {2} -o {0}campaign.yaml", at, lab.file, lab.options));
  ASSERT_EQ(shown.code, 0) << shown.out << shown.err;
  const std::string campaign = io::read_text(folder / "campaign.yaml");
  EXPECT_LE(std::count(campaign.begin(), campaign.end(), '\n'), 10) << campaign;

  const Outcome compared =
      kinetostat(fmt::format("compare {0}campaign.yaml --json {0}out.json", at));
  ASSERT_EQ(compared.code, 0) << campaign << compared.out << compared.err;
  const io::Json json = io::read_json(folder / "out.json");
  const io::Json& fitted = json.at(json.contains("fitted") ? "fitted" : "refitted");
  const double factor = fitted.at("parameters").at(0).at("factor").get<double>();
  EXPECT_NEAR(factor, 0.8, 0.004) << campaign << compared.out;
}

INSTANTIATE_TEST_SUITE_P(
    All, LabTables,
    testing::Values(Lab{"GermanCsv", slide, "Messung.csv", german_csv},
                    Lab{"GermanExcel", slide, "Messung.xlsx", excel_sheet},
                    Lab{"AmericanCsv", slide, "slide.csv", american_csv},
                    Lab{"Tracker", arm, "export.txt", tracker_export},
                    Lab{"DialGauges", slide, "gauges.csv", gauge_sheet,
                        "--column \"Load=fz\" --column \"Gauge 1=dx\" --column \"Gauge 2=-dz\""},
                    Lab{"Logger", slide, "log.csv", logger}),
    [](const auto& lab) { return lab.param.name; });

// The same without a campaign file: one table, one command.
TEST_P(LabTables, AreStudiedInOneCommand) {
  const Lab& lab = GetParam();
  const std::string at = "lab_study_" + lab.name;
  const std::filesystem::path folder = working_folder() / at;
  std::filesystem::create_directory(folder);
  io::write_atomically(folder / "robot.yaml", lab.robot);
  io::write_atomically(folder / lab.file, lab.content());
  const Outcome outcome = kinetostat(fmt::format(
      "study {0}/{1} {0}/robot.yaml {2} --noise 1um -o {0}/out", at, lab.file, lab.options));
  ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("campaign: " + at + "/out/campaign.yaml"));
  const io::Json json = io::read_json(folder / "out/comparison.json");
  const double factor = json.at("refitted").at("parameters").at(0).at("factor").get<double>();
  EXPECT_NEAR(factor, 0.8, 0.004) << outcome.out;
  EXPECT_TRUE(std::filesystem::exists(folder / "out/index.html"));
}

// Only what is plain: the serial number beside a tracker may be the tracker's.
TEST(StudyOfATable, KeepsWhatStandsAboveIt) {
  const std::filesystem::path folder = working_folder() / "above";
  std::filesystem::create_directory(folder);
  io::write_atomically(folder / "robot.yaml", slide);
  const auto about = [&](const std::string& above) {
    std::string table = above + "Nr;Fz [N];dz [um]\n";
    for (int i = 0; i < 7; ++i) table += fmt::format("{};{};{}\n", i, 200 * i, 250 * i + error(i));
    io::write_atomically(folder / "t.csv", table);
    EXPECT_EQ(kinetostat("readings above/t.csv above/robot.yaml --noise 1um -o above/c.yaml").code,
              0);
    EXPECT_EQ(kinetostat("diagnose above/c.yaml -q --json above/d.json").code, 0) << above;
    EXPECT_EQ(kinetostat("compare above/c.yaml -q --json above/m.json").code, 0) << above;
    io::Json campaign = io::read_json(folder / "d.json")["campaign"];
    const io::Json compared = io::read_json(folder / "m.json")["campaign"];
    for (const auto& [key, value] : campaign.items()) EXPECT_EQ(compared.at(key), value) << key;
    campaign.erase("name");
    return campaign;
  };
  EXPECT_EQ(
      about("Schlitten 3;\nDatum: 03.05.2026;\nPr\u00fcfer;A. Berger\nSeriennummer;\"4711\"\n"),
      (io::Json{{"date", "2026-05-03"}, {"operator", "A. Berger"}, {"serial", "4711"}}));
  EXPECT_EQ(about("# Date: 2026-05-03T14:22\n# Instrument: T3; Serial number: 99\n"),
            (io::Json{{"date", "2026-05-03"}, {"instrument", "T3"}}));
  EXPECT_EQ(about("Robot serial: R-7;Tracker: T3\nDate: 5/3/2026;Operator\n"),
            (io::Json{{"instrument", "T3"}, {"serial", "R-7"}}));
  EXPECT_EQ(about(""), io::Json::object());
}

// The file that was made is the user's as soon as it is edited.
TEST(StudyOfATable, KeepsWhatWasEdited) {
  const std::filesystem::path folder = working_folder() / "edited";
  std::filesystem::create_directory(folder);
  io::write_atomically(folder / "robot.yaml", slide);
  io::write_atomically(folder / "slide.csv", american_csv());
  const std::string command = "study edited/slide.csv edited/robot.yaml -o edited/out";
  const Outcome unknown = kinetostat(command);
  EXPECT_EQ(unknown.code, 5);  // and what would work is said
  EXPECT_THAT(unknown.err, HasSubstr("the noise is not known. Give --noise 3um, or add 'noise: "
                                     "{translation: 3 um}' to edited/out/campaign.yaml"));
  const std::string made = io::read_text(folder / "out/campaign.yaml");
  ASSERT_EQ(kinetostat("study edited/robot.yaml edited/slide.csv -o edited/out").code, 5);
  EXPECT_EQ(io::read_text(folder / "out/campaign.yaml"), made);
  io::write_atomically(folder / "out/campaign.yaml", made + "noise: {translation: 2 um}\n");
  const Outcome edited = kinetostat(command);
  ASSERT_EQ(edited.code, 0) << edited.err;
  EXPECT_THAT(edited.err, HasSubstr("edited/out/campaign.yaml was edited: it counts as it is"));
  EXPECT_THAT(edited.out, HasSubstr("noise stated"));
  const Outcome other = kinetostat(command + " --displacement absolute");
  EXPECT_EQ(other.code, 3);
  EXPECT_THAT(other.err, HasSubstr("would be made otherwise now. Study it itself, 'kinetostat "
                                   "study edited/out/campaign.yaml -o edited/out', or remove it"));
}

TEST(StudyOfATable, AsksForWhatOnlyPeopleKnow) {
  const std::filesystem::path folder = working_folder() / "asked";
  std::filesystem::create_directory(folder);
  io::write_atomically(folder / "robot.yaml", slide);
  io::write_atomically(folder / "gauges.csv", gauge_sheet());
  const Outcome alone = kinetostat("study asked/gauges.csv -o asked/out");
  EXPECT_EQ(alone.code, 3);
  EXPECT_THAT(alone.err, HasSubstr("Write 'kinetostat study asked/gauges.csv ROBOT.yaml -o "));
  const std::string command = "study asked/gauges.csv asked/robot.yaml -o asked/out";
  const Outcome load = kinetostat(command);
  EXPECT_EQ(load.code, 3);
  EXPECT_THAT(load.err, HasSubstr("--column 'Load=fz'"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out/campaign.yaml"));
  const Outcome gauges = kinetostat(command + " --column Load=fz");
  EXPECT_EQ(gauges.code, 3);
  EXPECT_THAT(gauges.err, HasSubstr("does not say what carries Gauge_1 and Gauge_2. Write it in "
                                    "this file instead of WHERE, then give the same command"));
  // One of them at the platform: the other is named, with what to add.
  const Outcome one = kinetostat(command + " --column Load=fz --column 'Gauge 2=-dz' --noise 1um");
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_THAT(one.err, HasSubstr("'Gauge 1 [um]' is not used; if it reads the platform, add "
                                 "--column \"Gauge 1 [um]=dx\""));
  const Outcome noise = kinetostat(command + " --column Load=fz --noise 3");
  EXPECT_EQ(noise.code, 2);
  EXPECT_THAT(noise.err, HasSubstr("Write --noise 3um"));
  const Outcome without = kinetostat("study asked/robot.yaml --units length=mm -o asked/out");
  EXPECT_EQ(without.code, 2);
  EXPECT_THAT(without.err, HasSubstr("none of the files is a table"));
}

struct Misplaced {
  std::string name, command, kind, right;
};

class MisplacedFiles : public testing::TestWithParam<Misplaced> {};

// One sentence that names what it is, and the command that takes it.
TEST_P(MisplacedFiles, AreNamedWithTheirCommand) {
  io::write_atomically(working_folder() / "misplaced.csv", "id,Fx [N],dx [um]\n1,2,3\n");
  const Outcome outcome = kinetostat(GetParam().command);
  EXPECT_EQ(outcome.code, 3) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().kind));
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().right));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

const std::string nist = "data/measurements/nist_load_cell/campaign.yaml";

INSTANTIATE_TEST_SUITE_P(
    All, MisplacedFiles,
    testing::Values(
        Misplaced{"MeshAsRobot", "stiffness meshes/foot.stl", "this is a mesh, not a robot file",
                  "kinetostat mesh check meshes/foot.stl --unit mm"},
        Misplaced{"MeshAsLink", "identify meshes/foot.stl", "a mesh, not a link file",
                  "kinetostat mesh check"},
        Misplaced{"TableAsRobot", "deflect misplaced.csv", "a table (CSV), not a robot file",
                  "kinetostat readings misplaced.csv -o campaign.yaml"},
        Misplaced{"TableAsCampaign", "compare data/robots/bench.yaml misplaced.csv",
                  "a table (CSV), not a campaign file", "kinetostat readings misplaced.csv"},
        Misplaced{"CampaignAsRobot", "stiffness " + nist, "a campaign file, not a robot file",
                  "kinetostat compare " + nist},
        Misplaced{"RobotAsCampaign", "compare data/robots/bench.yaml",
                  "a robot file, and no campaign file comes after it", "campaign.yaml"},
        Misplaced{"Swapped", "compare " + nist + " data/robots/bench.yaml",
                  "the robot file comes first", "compare data/robots/bench.yaml " + nist},
        Misplaced{"LinkAsRobot", "stiffness meshes/foot.yaml", "a link file, not a robot file",
                  "kinetostat identify meshes/foot.yaml"},
        Misplaced{"RobotAsLink", "identify data/robots/bench.yaml", "a robot file, not a link file",
                  "kinetostat stiffness data/robots/bench.yaml"},
        Misplaced{"LinkResultAsLink", "identify data/links/foot.link.json",
                  "the result of a link, not a link file", "names it under 'links'"},
        Misplaced{
            "UrdfAsRobot", "stiffness data/urdf/six_axis.urdf",
            "a robot description (URDF, SDF, MJCF or a Denavit-Hartenberg table), not a robot file",
            "kinetostat import data/urdf/six_axis.urdf"},
        Misplaced{"RobotAsMesh", "mesh check data/robots/bench.yaml --unit mm",
                  "a robot file, not a mesh", "kinetostat stiffness"},
        Misplaced{"RobotAsDiagnosis", "adopt data/robots/bench.yaml data/robots/bench.yaml",
                  "a robot file, not a diagnosis", "kinetostat stiffness"},
        Misplaced{"RobotAsTable", "readings data/robots/bench.yaml",
                  "a robot file, not a table (CSV) or a campaign file", "kinetostat stiffness"}),
    [](const auto& test) { return test.param.name; });

// What cannot be used is listed, and no campaign file is written.
TEST(Readings, ListsWhatCannotBeUsed) {
  io::write_atomically(working_folder() / "unclear.csv", "Kraft X,dz\n1,2\nx,3\n");
  const Outcome outcome = kinetostat("readings unclear.csv -o unclear.yaml");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.out, HasSubstr("'Kraft X' has no unit"));
  EXPECT_THAT(outcome.out, HasSubstr("'dz' has no unit"));
  EXPECT_THAT(outcome.out, HasSubstr("'x' is not a number"));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "unclear.yaml"));
}

// Two joints about parallel axes in one posture: what one is found to be may be the other.
TEST(Readings, SayWhatIsConfounded) {
  io::write_atomically(working_folder() / "elbow.yaml", R"(kinetostat: 1
name: elbow
units: {length: mm, force: N, angle: deg}
chain_types:
  arm: [{actuator: {name: turn, axis: Rz, stiffness: 1e6 N m/rad}},
        {actuator: {name: shoulder, axis: Ry, stiffness: 1e5 N m/rad}}, {offset: [500, 0, 0]},
        {actuator: {name: elbow, axis: Ry, stiffness: 1e5 N m/rad}}, {offset: [500, 0, 0]}]
manipulator: {chain: arm}
uncertain: [{stiffness: turn}, {stiffness: shoulder}, {stiffness: elbow}]
)");
  std::string text = "fz [N],dz [mm],sigma_dz [mm]\n";
  for (const double f : {-300, -200, -100, 100, 200})
    text += fmt::format("{},{},0.01\n", f, f / 60);
  io::write_atomically(working_folder() / "elbow.csv", text);
  ASSERT_EQ(kinetostat("readings elbow.csv elbow.yaml -o elbow_campaign.yaml --quiet").code, 0);
  const Outcome outcome = kinetostat("compare elbow_campaign.yaml --quiet");
  EXPECT_THAT(outcome.out, HasSubstr("confounded with these, kept: elbow; not determined, kept: "
                                     "turn"));
}

// Of the program as it has been run so far by this process [kB].
long most_memory() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage.ru_maxrss;
}

// 35,000 rows: read and compared within the memory that a small machine has.
TEST(Readings, OfALoggerAreComparedInBoundedMemory) {
  io::write_atomically(working_folder() / "slide.yaml", slide);
  std::string text = "time [s],cycle,step,Fx [N],Fy [N],Fz [N],dx [um],dy [um],dz [um],note\n";
  for (int i = 0; i < 35000; ++i)
    text += fmt::format("{:.1f},{},{},0.1,-0.2,{:.3f},{:.3f},{:.3f},{:.3f},run\n", 0.1 * i, i / 500,
                        i % 500, 500 + 500 * std::sin(0.05 * i), error(i), error(i + 1),
                        1250 * (0.5 + 0.5 * std::sin(0.05 * i)) + error(i + 2));
  io::write_atomically(working_folder() / "long.csv", text);
  ASSERT_EQ(kinetostat("readings long.csv slide.yaml -o long.yaml --quiet").code, 0);
  std::ofstream(working_folder() / "long.yaml", std::ios::app) << "noise: {translation: 1 um}\n";
  [[maybe_unused]] const long before = most_memory();
  EXPECT_EQ(kinetostat("compare long.yaml --quiet").code, 0);
#ifndef __SANITIZE_ADDRESS__
  constexpr long enough = 100'000;  // measured: 95,000
  EXPECT_LE(most_memory(), std::max(before, enough));
#endif
}

}  // namespace
}  // namespace kinetostat::lab_tables_test
