// Many runs as one table, as users meet them.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::sweep_test {
namespace {

using test::kinetostat;
using test::working_folder;
using testing::HasSubstr;

// A lever of length 1 m on one drive: it sags by F / k.
const std::string lever =
    "kinetostat: 1\nname: lever\nunits: {length: m, force: N, angle: rad}\nlinks:\n  bar: {rigid: "
    "[1, 0, 0]}\nchain_types:\n  arm:\n    - actuator: {name: q, axis: Ry, stiffness: 1e4}\n    - "
    "link: bar\nmanipulator: {chain: arm}\n";

std::string sweep_file(const std::string& vary, const std::string& rest = "",
                       const std::string& command = "deflect lever.yaml --wrench 0,0,1") {
  return "kinetostat: 1\nsweep: lever\ncommand: " + command + "\nvary:\n" + vary + rest +
         "results: {sag: equilibrium.displacement.translation.2, none: no.such}\n";
}

class Sweep : public testing::Test {
 protected:
  void SetUp() override {
    io::write_atomically(working_folder() / "lever.yaml", lever);
    std::filesystem::remove(working_folder() / "out.csv.part");
  }
  static test::Outcome run(const std::string& file, const std::string& options = "-o out.csv") {
    io::write_atomically(working_folder() / "sweep.yaml", file);
    return kinetostat("sweep sweep.yaml " + options);
  }
  static io::CsvTable table(const std::string& name = "out.csv") {
    return io::read_csv(working_folder() / name);
  }
};

const std::string by_stiffness =
    "  - {set: chain_types.arm.q.stiffness, from: 1, to: 100, steps: 3, scale: log, unit: kN "
    "m/rad}\n";

TEST_F(Sweep, OfAGridHasEveryValueWithEveryOther) {
  const test::Outcome outcome =
      run(sweep_file(by_stiffness + "  - {set: 'links.bar.rigid', values: ['[1, 0, 0]', '[2, 0, "
                                    "0]']}\n"));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::CsvTable found = table();
  ASSERT_EQ(found.rows(), 6u);
  for (std::size_t r = 0; r < 6; ++r) {
    const double k = 1e3 * std::pow(10.0, double(r / 2)), arm = r % 2 == 0 ? 1 : 2;
    const double sag = found.number(r, *found.find("sag"));
    EXPECT_NEAR(sag, arm * arm / k, 1e-5 * sag);
    EXPECT_EQ(found.cell(r, *found.find("none")), "");
    EXPECT_EQ(found.cell(r, *found.find("exit")), "0");
  }
}

TEST_F(Sweep, HasTheSameBytesOnAnyNumberOfThreadsAndInParts) {
  const std::string file =
      sweep_file("  - {set: chain_types.arm.q.stiffness, from: 1e3, to: 1e5}\n",
                 "sample: {method: sobol, count: 7}\n");
  ASSERT_EQ(run(file, "-o one.csv --threads 1").code, 0);
  ASSERT_EQ(run(file, "-o two.csv --threads 2").code, 0);
  const std::string one = io::read_text(working_folder() / "one.csv");
  EXPECT_EQ(one, io::read_text(working_folder() / "two.csv"));
  for (const int i : {3, 1, 2})
    ASSERT_EQ(run(file, fmt::format("--part {}/3 -o part{}.csv", i, i)).code, 0);
  ASSERT_EQ(kinetostat("join part3.csv part1.csv part2.csv -o all.csv").code, 0);
  EXPECT_EQ(one, io::read_text(working_folder() / "all.csv"));
  const test::Outcome missing = kinetostat("join part3.csv part1.csv");
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.err, HasSubstr("row 1 of 7 is in none"));
  ASSERT_EQ(run(sweep_file(by_stiffness), "-o other.csv").code, 0);
  EXPECT_THAT(kinetostat("join part1.csv other.csv").err, HasSubstr("another table"));
  EXPECT_EQ(kinetostat("join lever.yaml").code, 3);
  // A part that was cut off, and one that says something else.
  const std::string part = io::read_text(working_folder() / "part3.csv");
  io::write_atomically(working_folder() / "cut.csv", part.substr(0, part.size() - 6));
  const test::Outcome cut = kinetostat("join cut.csv part1.csv part2.csv -o cut_all.csv");
  EXPECT_EQ(cut.code, 3);
  EXPECT_THAT(cut.err, HasSubstr("its last line has no end"));
  std::string changed = part;
  changed.replace(changed.size() - 2, 1, changed[changed.size() - 2] == '1' ? "2" : "1");
  io::write_atomically(working_folder() / "changed.csv", changed);
  const test::Outcome two = kinetostat("join part3.csv changed.csv part1.csv part2.csv");
  EXPECT_EQ(two.code, 3);
  EXPECT_THAT(two.err, HasSubstr("is not what another of the files has"));
  EXPECT_EQ(run(file, "--part 4/3").code, 2);
  EXPECT_EQ(run(file, "--part 1").code, 2);
}

// Sobol's points of one dimension are the halves, quarters ... in some order; drawn ones lie within
// the range, and another seed draws others.
TEST_F(Sweep, SamplesFillTheRange) {
  const auto stiffness = [](const std::string& sample) {
    const test::Outcome outcome =
        run(sweep_file("  - {set: chain_types.arm.q.stiffness, from: 1000, to: 9000}\n", sample));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::vector<double> values;
    const io::CsvTable found = table();
    for (std::size_t r = 0; r < found.rows(); ++r) values.push_back(found.number(r, 1));
    std::sort(values.begin(), values.end());
    return values;
  };
  EXPECT_EQ(stiffness("sample: {method: sobol, count: 7}\n"),
            (std::vector<double>{2000, 3000, 4000, 5000, 6000, 7000, 8000}));
  const std::vector<double> one = stiffness("sample: {method: random, count: 9, seed: 1}\n"),
                            two = stiffness("sample: {method: random, count: 9, seed: 2}\n");
  EXPECT_NE(one, two);
  EXPECT_EQ(one, stiffness("sample: {method: random, count: 9, seed: 1}\n"));
  EXPECT_GE(one.front(), 1000);
  EXPECT_LE(one.back(), 9000);
}

// What is kept of a run that was stopped is not computed again: a kept line with a mark comes back.
TEST_F(Sweep, GoesOnFromWhereItWasStopped) {
  const std::string file = sweep_file(by_stiffness);
  ASSERT_EQ(run(file).code, 0);
  const std::string whole = io::read_text(working_folder() / "out.csv");
  const std::string title = whole.substr(0, whole.find('\n') + 1);
  io::write_atomically(working_folder() / "out.csv.part",
                       title + "1,10 kN m/rad,0.5,kept,0\n2,100 kN");  // the last was cut short
  const test::Outcome outcome = run(file);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(table().cell(1, *table().find("none")), "kept");
  EXPECT_NEAR(table().number(2, *table().find("sag")), 1e-5, 1e-9);
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "out.csv.part"));
  // Nor is a row that a full disk or a loss of power has spoilt.
  io::write_atomically(working_folder() / "out.csv.part",
                       title + "0,1 kN m/rad\n1,10 kN m/rad,0.5,kept,0,1\n2,100 kN m/rad,1,,x\n" +
                           std::string(30, '\0') + "\n");
  ASSERT_EQ(run(file).code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "out.csv"), whole);
  // Of another sweep nothing is taken.
  io::write_atomically(working_folder() / "out.csv.part", "# sweep 0 of 3 runs\n1,1,0.5,kept,0\n");
  ASSERT_EQ(run(file).code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "out.csv"), whole);
}

// One run a campaign, each with its file: as diagnosed one by one.
TEST_F(Sweep, OfWordsRunsEveryFileOfAPattern) {
  const auto lever_of = [](double length) {
    std::string text = lever;
    text.replace(text.find("[1, 0, 0]"), 9, fmt::format("[{}, 0, 0]", length));
    return text;
  };
  for (const int k : {1, 2, 3}) {
    std::filesystem::create_directories(working_folder() / fmt::format("levers/{}", k));
    io::write_atomically(working_folder() / fmt::format("levers/{}/lever.yaml", k), lever_of(k));
  }
  const std::string file = sweep_file(
      "  - {word: robot, files: 'levers/*/lever.yaml'}\n  - {word: force, values: ['0,0,1', "
      "'0,0,2']}\n",
      "", "deflect {robot} --wrench {force} -o {robot}.{force}.txt");
  ASSERT_EQ(run(file).code, 0);
  const io::CsvTable found = table();
  ASSERT_EQ(found.rows(), 6u);
  for (std::size_t r = 0; r < 6; ++r) {
    const double length = 1 + double(r / 2), force = 1 + double(r % 2);
    const double sag = found.number(r, *found.find("sag"));
    EXPECT_NEAR(sag, force * length * length / 1e4, 1e-3 * sag);
    EXPECT_TRUE(std::filesystem::exists(
        working_folder() / fmt::format("levers/{}/lever.yaml.0,0,{}.txt", length, force)));
  }
  const std::string whole = io::read_text(working_folder() / "out.csv");
  for (const int i : {1, 2})
    ASSERT_EQ(run(file, fmt::format("--part {}/2 -o part{}.csv", i, i)).code, 0);
  ASSERT_EQ(kinetostat("join part1.csv part2.csv -o all.csv").code, 0);
  EXPECT_EQ(whole, io::read_text(working_folder() / "all.csv"));
  EXPECT_THAT(run(sweep_file("  - {word: robot, values: [a, b]}\n")).err,
              HasSubstr("the command has no word {robot}"));
  EXPECT_THAT(run(sweep_file("  - {word: robot, files: nowhere/*.yaml}\n")).err,
              HasSubstr("no such file"));
}

TEST_F(Sweep, NamesMistakes) {
  const auto message = [](const std::string& file) {
    const test::Outcome outcome = run(file);
    EXPECT_EQ(outcome.code, 3) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(message(sweep_file("  - {set: chain_types.arm.p.stiffness, values: [1]}\n")),
              HasSubstr("there is no 'p' under 'chain_types.arm'"));
  EXPECT_THAT(message(sweep_file("  - {set: a, from: 1, to: 2}\n")), HasSubstr("has no steps"));
  EXPECT_THAT(message(sweep_file("  - {set: a, from: 0, to: 2, steps: 3, scale: log}\n")),
              HasSubstr("above zero"));
  EXPECT_THAT(message(sweep_file(by_stiffness, "", "deflect lever.yaml -o x.txt")),
              HasSubstr("which every run would write"));
  EXPECT_THAT(message(sweep_file(by_stiffness, "", "deflect lever.yaml -ox.txt")),
              HasSubstr("which every run would write"));
  EXPECT_THAT(message(sweep_file(by_stiffness + by_stiffness)), HasSubstr("varies already"));
  EXPECT_THAT(message(sweep_file("  - {word: exit, values: [a]}\n")),
              HasSubstr("has a column 'exit' already"));
  const auto with_result = [](const std::string& result) {
    return "kinetostat: 1\nsweep: lever\ncommand: deflect lever.yaml --wrench 0,0,1\nvary:\n" +
           by_stiffness + "results: {" + result + "}\n";
  };
  for (const char* taken : {"run", "exit", "chain_types.arm.q.stiffness"})
    EXPECT_THAT(message(with_result(fmt::format("{}: headline", taken))),
                testing::ContainsRegex("sweep.yaml:[0-9]+: .*has a column '.*' already"));
  EXPECT_THAT(message(sweep_file(by_stiffness, "",
                                 "deflect lever.yaml --wrench 0,0,1 --set "
                                 "chain_types.arm.q.stiffness=5")),
              HasSubstr("it sets 'chain_types.arm.q.stiffness', which varies"));
  EXPECT_THAT(
      message(with_result("all: equilibrium.displacement")),
      testing::ContainsRegex("sweep.yaml:[0-9]+: results.all: 'equilibrium.displacement' is "
                             "no single value.*: it has equilibrium.displacement[.]"));
  EXPECT_THAT(run(sweep_file(by_stiffness)).err, HasSubstr("'none' is empty: no run has"));
  for (const char* threads : {"--threads 1", "--threads 3"})
    EXPECT_THAT(
        run(sweep_file("  - {set: chain_types.arm.q.stiffness, values: [1e4, -1, -2]}\n"), threads)
            .err,
        HasSubstr("run 1: "));
  EXPECT_THAT(message(sweep_file(by_stiffness, "smaple: {}\n")),
              HasSubstr("Did you mean 'sample'"));
}

// After one run, which shows it: no other one is made, and nothing is kept of it.
TEST_F(Sweep, OfWhatIsNoCellOfATableEndsBeforeItsRuns) {
  const std::string file =
      "kinetostat: 1\nsweep: lever\ncommand: deflect lever.yaml --wrench 0,0,1 -o {name}.txt\n"
      "vary: [{word: name, values: [a, b, c, d]}]\nresults: {of_all: headline, all: equilibrium}\n";
  for (const char* threads : {"--threads 1", "--threads 3"}) {
    for (const char* name : {"a.txt", "b.txt", "c.txt", "d.txt", "fits.csv"})
      std::filesystem::remove(working_folder() / name);
    const test::Outcome outcome = run(file, std::string("-o fits.csv ") + threads);
    EXPECT_EQ(outcome.code, 3) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr("sweep.yaml:5: results.all: 'equilibrium' is no single"));
    EXPECT_TRUE(std::filesystem::exists(working_folder() / "a.txt"));
    for (const char* name : {"b.txt", "c.txt", "d.txt", "fits.csv"})
      EXPECT_FALSE(std::filesystem::exists(working_folder() / name)) << name;
  }
}

}  // namespace
}  // namespace kinetostat::sweep_test
