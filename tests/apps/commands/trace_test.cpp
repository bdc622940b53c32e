// `kinetostat trace` as its users meet it.
#include <cmath>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::trace_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

io::Json json_of(const std::string& arguments) {
  const Outcome outcome = kinetostat(arguments + " --quiet --json trace.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return io::Json::parse(io::read_text(working_folder() / "trace.json"));
}

TEST(TraceCommand, FindsTheTwoWaysInWhichTheStraightChainGivesWay) {
  const io::Json result =
      json_of("trace data/robots/urrs_a.yaml --along -270,0,0 --branches -o trace.csv");
  const io::Json& critical = result["path"]["critical_points"];
  ASSERT_GE(critical.size(), 2U);
  EXPECT_NEAR(critical[0]["point"]["along"]["force"].get<double>(), 1000.0 / 3, 1e-5);
  EXPECT_NEAR(critical[1]["point"]["along"]["force"].get<double>(), 1000, 1e-5);
  EXPECT_EQ(result["path"]["at_target"].size(), 4U);
  EXPECT_TRUE(result["path"]["at_target"][0]["stable"].get<bool>());
  EXPECT_FALSE(result["path"]["at_target"][3]["stable"].get<bool>());

  // The spreadsheet says the same: energy 2 x K phi^2 / 2 with cos(phi) = 1 - 270 / 600.
  const io::CsvTable table = io::read_csv(working_folder() / "trace.csv");
  const std::size_t parameter = *table.find("parameter");
  const double phi = std::acos(1 - 270.0 / 600);
  int ends = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.cell(row, parameter) != "1" || table.cell(row, *table.find("stable")) != "1")
      continue;
    EXPECT_NEAR(table.number(row, *table.find("elastic_energy")), 100 * phi * phi, 1e-9);
    EXPECT_NEAR(table.number(row, *table.find("dx")), -270, 1e-9);
    ++ends;
  }
  EXPECT_EQ(ends, 2);
}

// A steel cantilever of 1 m, 20 x 10 mm: Euler's load is pi^2 E I / 4 L^2 = 863.6 N. One spring per
// beam does not feel it.
class SlenderBeam : public ::testing::Test {
 protected:
  SlenderBeam() {
    std::ofstream(working_folder() / "beam.yaml") << R"(kinetostat: 1
name: slender beam
units: {length: mm, force: N, angle: deg}
materials:
  steel: {E: 210 GPa, nu: 0.3}
links:
  rod: {beam: {length: 1000, section: {rectangle: {y: 20, z: 10}}, material: steel}}
chain_types:
  rod: [{link: rod}]
manipulator: {chain: rod}
)";
  }
  const double euler = M_PI * M_PI / 4 * 210e9 * (20e-3 * 1e-9 * 1e3 / 12);
};

TEST_F(SlenderBeam, IsUnstableUnderSixTimesEulersLoad) {
  ASSERT_NEAR(6 * euler, 5181, 1);
  const Outcome over = kinetostat("deflect beam.yaml --wrench=-5181,0,0 --json over.json");
  EXPECT_EQ(over.code, 4);
  EXPECT_THAT(over.out, HasSubstr("a beam buckles that one spring keeps straight"));
  const io::Json json = io::Json::parse(io::read_text(working_folder() / "over.json"));
  EXPECT_TRUE(json["hidden_buckling"].get<bool>());
  EXPECT_FALSE(json["equilibrium"]["stability"]["platform_free"]["stable"].get<bool>());
  const Outcome under = kinetostat("deflect beam.yaml --wrench=-800,0,0");
  EXPECT_EQ(under.code, 0);
  EXPECT_THAT(under.out, testing::Not(HasSubstr("buckles")));
}

TEST_F(SlenderBeam, BucklesOnItsPathAtEulersLoad) {
  const io::Json result = json_of("trace beam.yaml --wrench=-5181,0,0");
  EXPECT_TRUE(result["path"]["critical_points"].empty());
  EXPECT_EQ(result["segments"]["multiples_without_critical_point"], io::Json::array({1}));
  EXPECT_NEAR(result["segments"]["estimate"].get<double>(), euler, 0.02 * euler);
}

TEST(TraceCommand, SaysWhatOneSpringPerBeamIsWorth) {
  const Outcome outcome =
      kinetostat("trace data/robots/urrs_c.yaml --along -3,0,0 --segments 4,8 --json trace.json");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("warning: with the segments of the robot file"));
  const io::Json result = io::Json::parse(io::read_text(working_folder() / "trace.json"));
  // Euler's column out of the plane, pi^2 / 9 E Iy / L^2; its beams hardly shorten.
  const double euler = 9.8696044 / 9 * 70e9 * 0.015 * 0.006 * 0.006 * 0.006 / 12 / 0.09;
  EXPECT_NEAR(result["segments"]["estimate"].get<double>(), euler, 1e-3 * euler);
}

TEST(TraceCommand, RefusesToStartWithoutSomethingThatGrows) {
  const Outcome outcome = kinetostat("trace data/robots/urrs_a.yaml");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--along"));
}

TEST(TraceCommand, IsTheSameByteForByteEveryTime) {
  const std::string command =
      "trace data/robots/urrs_c.yaml --along -30,0,0 --branches --quiet --json ";
  kinetostat(command + "first.json");
  kinetostat(command + "second.json");
  EXPECT_EQ(io::read_text(working_folder() / "first.json"),
            io::read_text(working_folder() / "second.json"));
}

}  // namespace
}  // namespace kinetostat::trace_test
