// How certain results are, as the users of commands meet it.
#include <cmath>
#include <regex>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::uncertainty_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

io::Json result_of(const std::string& arguments) {
  const Outcome outcome = kinetostat(arguments + " --json uncertainty.json");
  EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
  return io::read_json(working_folder() / "uncertainty.json");
}

double sum_of_shares(const io::Json& budget) {
  double sum = 0;
  for (const io::Json& source : budget) sum += source["share"].get<double>();
  return sum;
}

// A shipped robot with this in the place of what the expression finds.
void write_robot(const std::string& from, const std::string& expression, const std::string& with,
                 const std::string& name) {
  const std::string text = io::read_text(working_folder() / "data/robots" / from);
  const std::string changed = std::regex_replace(text, std::regex(expression), with);
  EXPECT_NE(text, changed) << from;
  io::write_atomically(working_folder() / name, changed);
}

// Parts of the draws, joined, and the result from them: the bytes of one run.
TEST(Uncertainty, DrawsInPartsAreThoseOfOneRun) {
  const std::string command = "deflect data/robots/gantry.yaml --wrench 0,300,0 --draws 37 ";
  const auto bytes_of = [](const std::string& arguments) {
    io::Json json = result_of(arguments);
    for (const char* key : {"part", "drawn"}) json["options"].erase(key);
    return json.dump();
  };
  const std::string whole = bytes_of(command);
  for (const int i : {2, 3, 1}) {
    const Outcome part = kinetostat(command + fmt::format("--part {}/3 --drawn d.{}.csv", i, i));
    EXPECT_EQ(part.code, 0) << part.err;
    EXPECT_THAT(part.err, HasSubstr("of 37 draws are in"));
  }
  ASSERT_EQ(kinetostat("join d.3.csv d.1.csv d.2.csv -o d.csv").code, 0);
  EXPECT_EQ(bytes_of(command + "--drawn d.csv"), whole);
  EXPECT_EQ(bytes_of(command + "--drawn d.1.csv --threads 2"), whole);  // the others are added
  EXPECT_EQ(io::read_text(working_folder() / "d.csv"), io::read_text(working_folder() / "d.1.csv"));
  const Outcome other = kinetostat(command + "--seed 3 --drawn d.csv");
  EXPECT_EQ(other.code, 3);
  EXPECT_THAT(other.err, HasSubstr("draws of another robot"));
  EXPECT_EQ(kinetostat(command + "--part 1/2").code, 2);
  EXPECT_EQ(kinetostat("deflect data/robots/gantry.yaml --wrench 0,300,0 --drawn d.csv").code, 2);
  EXPECT_EQ(
      kinetostat("stiffness data/robots/gantry.yaml --wrench 0,300,0 --draws 9 --drawn d.csv").code,
      2);
}

TEST(Uncertainty, StiffnessSaysHowWellItIsKnownAndWhichNumberIsToBlame) {
  const Outcome outcome = kinetostat("stiffness data/robots/gantry.yaml --at 100,50,20");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr(" +- "), HasSubstr("Of its uncertainty, "),
                                 HasSubstr("(k = 2)"), Not(HasSubstr("draws"))));
  const io::Json json = result_of("stiffness data/robots/gantry.yaml --at 100,50,20");
  EXPECT_THAT(json["headline"].get<std::string>(), HasSubstr("Of its uncertainty, "));
  EXPECT_NEAR(sum_of_shares(json["uncertainty"]["budget"]), 1, 1e-12);
  EXPECT_EQ(json["uncertainty"]["budget"].size(), 7u);
  EXPECT_EQ(json["uncertainty"]["compliance"].size(), 6u);
}

// One spring and nothing else: 1.37e6 N/mm to 4 % (1 sd) is the whole uncertainty, U = 8 %.
TEST(Uncertainty, OfOneSpringIsThatSpring) {
  write_robot("bench.yaml", "stiffness: 1.37e6", "stiffness: {value: 1.37e6, sd: 4 %}",
              "one_spring.yaml");
  const io::Json json = result_of("stiffness one_spring.yaml");
  const io::Json& along = json["uncertainty"]["compliance_along"];
  EXPECT_NEAR(along["expanded_uncertainty"].get<double>() / along["value"].get<double>(), 0.08,
              1e-8);
  EXPECT_THAT(json["headline"].get<std::string>(), HasSubstr("+- 8 %"));
}

TEST(Uncertainty, WhereTheFileSaysNothingThereIsNone) {
  for (const char* command : {"stiffness data/robots/six_axis.yaml",
                              "deflect data/robots/six_axis.yaml --wrench 0,0,-100",
                              "assemble data/robots/orthoglide_errors.yaml --at 0,0,0"}) {
    const io::Json json = result_of(command);
    EXPECT_FALSE(json.contains("uncertainty")) << command;
    EXPECT_FALSE(json["options"].contains("draws")) << command;
  }
  EXPECT_FALSE(
      result_of("stiffness data/robots/gantry.yaml --no-uncertainty").contains("uncertainty"));
  const Outcome outcome = kinetostat("stiffness data/robots/six_axis.yaml --draws 100");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("--draws"), HasSubstr("{value: 2.0e4, sd: 5 %}")));
}

TEST(Uncertainty, DrawsAgreeWithFirstOrderAndAreTheSameOnAnyNumberOfThreads) {
  const std::string command =
      "deflect data/robots/gantry.yaml --wrench 0,300,0 --draws 300 --seed 4 --threads ";
  const io::Json one = result_of(command + "1"), two = result_of(command + "2");
  EXPECT_EQ(one["uncertainty"], two["uncertainty"]);
  const io::Json& moved = one["uncertainty"]["moved"];
  EXPECT_NEAR(2 * moved["draws"]["standard_deviation"].get<double>() /
                  moved["expanded_uncertainty"].get<double>(),
              1, 0.1);
  EXPECT_NEAR(sum_of_shares(moved["budget"]), 1, 1e-12);
  EXPECT_FALSE(one["uncertainty"].contains("force"));  // it is given
}

TEST(Uncertainty, OfADisplacementThatIsHeldIsThatOfItsForce) {
  const io::Json json = result_of("deflect data/robots/gantry.yaml --move 0,0.1,0");
  EXPECT_FALSE(json["uncertainty"].contains("moved"));
  EXPECT_NEAR(sum_of_shares(json["uncertainty"]["force"]["budget"]), 1, 1e-12);
  EXPECT_THAT(json["headline"].get<std::string>(),
              testing::ContainsRegex("N \\+- [0-9.]+ % along"));
}

TEST(Uncertainty, AMapHasAColumnOfIt) {
  ASSERT_EQ(kinetostat("map data/robots/gantry.yaml --grid x=-200:200:3,y=0,z=50 "
                       "--index weakest-translation --draws 50 -o sure.csv")
                .code,
            0);
  const io::CsvTable table = io::read_csv(working_folder() / "sure.csv");
  const auto cell = [&](const std::string& column) {
    const auto at = table.find(column);
    EXPECT_TRUE(at) << column;
    return at ? table.number(1, *at) : 0;
  };
  const double stiffness = cell("weakest-translation [N/mm]");
  EXPECT_GT(cell("uncertainty of weakest-translation [N/mm]"), 0.01 * stiffness);
  EXPECT_LT(cell("2.5 % of weakest-translation [N/mm]"), stiffness);
  EXPECT_GT(cell("97.5 % of weakest-translation [N/mm]"), stiffness);
}

// A critical force of springs alone is homogeneous of the first degree in them, and these two are
// alike: each has half of the derivative, u / F = 5 % (1/2, 1/2) by the root of the squares.
TEST(Uncertainty, OfACriticalForceFollowsItsSprings) {
  write_robot("urrs_a.yaml", "stiffness: 100 N m/rad", "stiffness: {value: 100 N m/rad, sd: 5 %}",
              "uncertain_urrs.yaml");
  const io::Json json = result_of("trace uncertain_urrs.yaml --along -50,0,0");
  const io::Json& uncertainty = json["uncertainty"];
  EXPECT_EQ(uncertainty["at"], "first critical point");
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(uncertainty["force"]["expanded_uncertainty"].get<double>() /
                  uncertainty["force"]["value"].get<double>(),
              0.1 * half, 1e-4);
}

TEST(Uncertainty, OfWhatIsAssembledAndCompensated) {
  write_robot("orthoglide_errors.yaml", "E: 70 GPa", "E: {value: 70 GPa, sd: 3 %}",
              "uncertain_glide.yaml");
  const io::Json assembled = result_of("assemble uncertain_glide.yaml --at 0,0,0");
  EXPECT_NEAR(sum_of_shares(assembled["uncertainty"]["moved"]["budget"]), 1, 1e-12);
  const io::Json compensated = result_of(
      "compensate uncertain_glide.yaml --path data/paths/orthoglide_milling.csv -o sure_path.csv");
  EXPECT_EQ(compensated["uncertainty"]["expanded"].size(), 21u);
  EXPECT_GT(compensated["uncertainty"]["largest_translation"].get<double>(), 1e-6);
  const io::CsvTable table = io::read_csv(working_folder() / "sure_path.csv");
  EXPECT_TRUE(table.find("uncertainty_x [mm]"));
}

}  // namespace
}  // namespace kinetostat::uncertainty_test
