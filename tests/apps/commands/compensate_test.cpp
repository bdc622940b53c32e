// kinetostat compensate, loads at nodes and the papers' iteration as their users meet them.
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::compensate_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;
using testing::Not;

const std::string milling =
    "compensate data/robots/orthoglide_errors.yaml --path data/paths/orthoglide_milling.csv ";

double value(const io::CsvTable& table, std::size_t row, const std::string& column) {
  const auto at = table.find(column);
  EXPECT_TRUE(at) << column;
  return at ? table.number(row, *at) : 0;
}

TEST(CompensateCommand, ShippedMillingPathLosesItsTranslationalErrors) {
  const Outcome outcome = kinetostat(milling + "-o milling.csv --json milling.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("21 poses, 21 compensated in x, y, z"));
  const io::Json json = io::read_json(working_folder() / "milling.json");
  EXPECT_GT(json["error"]["largest_translation"].get<double>(), 5e-4);
  EXPECT_LT(json["residual"]["largest_translation"].get<double>(), 1e-10);
}

// The commands of the table, given to another command, lead to the target.
TEST(CompensateCommand, ItsActuatorValuesLeadDeflectToTheTarget) {
  ASSERT_EQ(kinetostat(milling + "-o again.csv").code, 0);
  const io::CsvTable table = io::read_csv(working_folder() / "again.csv");
  std::string joints;
  for (const char* chain : {"x", "y", "z"})
    joints += (joints.empty() ? "" : ",") + std::string(chain) +
              ".rho=" + std::string(table.cell(7, *table.find(std::string(chain) + ".rho [mm]")));
  const Outcome outcome =
      kinetostat("deflect data/robots/orthoglide_errors.yaml --joints " + joints +
                 " --wrench 215,-10,-25,1000,21500,0 --json there.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::Json json = io::read_json(working_folder() / "there.json");
  const auto position = json["equilibrium"]["platform"]["position"].get<std::vector<double>>();
  const char* names[] = {"x [mm]", "y [mm]", "z [mm]"};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(1e3 * position[i], value(table, 7, names[i]), 1e-7);
}

TEST(CompensateCommand, SaysOfAPathWithoutACoordinateThatItIsZero) {
  io::write_atomically(working_folder() / "flat.csv", "x,y\n0,10\n10,0\n");
  const Outcome flat = kinetostat("compensate data/robots/orthoglide_errors.yaml --path flat.csv");
  EXPECT_EQ(flat.code, 0) << flat.err;
  EXPECT_THAT(flat.err, HasSubstr("flat.csv has no column z: it is 0 in every pose"));
  io::write_atomically(working_folder() / "whole.csv", "x,y,z\n0,10,0\n10,0,0\n");
  const Outcome whole =
      kinetostat("compensate data/robots/orthoglide_errors.yaml --path whole.csv");
  EXPECT_THAT(whole.err, Not(HasSubstr("no column")));
  EXPECT_EQ(whole.out, flat.out);
  // The work of 'plan' is a path, too; the command ends at the diagnosis that is not there.
  const Outcome plan = kinetostat(
      "plan data/measurements/orthoglide_clearance/campaign.yaml --work-at flat.csv --diagnosis "
      "nowhere.json");
  EXPECT_THAT(plan.err, HasSubstr("flat.csv has no column z: it is 0 in every pose"));
}

TEST(CompensateCommand, SameBytesForAnyNumberOfThreads) {
  for (const char* n : {"1", "2"})
    ASSERT_EQ(kinetostat(milling + "-o threads" + n + ".csv --threads " + n).code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "threads1.csv"),
            io::read_text(working_folder() / "threads2.csv"));
}

TEST(CompensateCommand, MistakesAreNamed) {
  const Outcome components = kinetostat(milling + "--components x,w");
  EXPECT_EQ(components.code, 2);
  EXPECT_THAT(components.err, HasSubstr("'w' is none of"));
  EXPECT_EQ(kinetostat("compensate data/robots/orthoglide.yaml").code, 2);
  EXPECT_EQ(kinetostat(milling + "--wrench 1,0,0").code, 2);
}

TEST(NodeLoad, ActsOnTheElbowOfTheHeavyArm) {
  const std::string heavy = "deflect data/robots/heavy_arm.yaml ";
  const Outcome alone = kinetostat(heavy + "--json weight.json");
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_THAT(alone.out, testing::StartsWith("By its weight: the platform moves"));
  EXPECT_THAT(alone.out, HasSubstr("Lumping of springs and weight"));
  const Outcome loaded = kinetostat(heavy + "--node-load elbow=0,0,-5000 --json elbow.json");
  ASSERT_EQ(loaded.code, 0) << loaded.err;
  const auto drop = [](const char* file) {
    return io::read_json(working_folder() / file)["equilibrium"]["platform"]["position"][2]
        .get<double>();
  };
  // 5000 N, 393 mm before the shoulder, which is 1.741 m behind the tool; across the upper arm,
  // 1.15 m long and 20 degrees from upright, sin 20 of it, which bends that arm (EI = 4.62e6 N m^2)
  // and with it what stands 1.348 m before the elbow.
  const double across = 5000 * std::sin(20 * M_PI / 180), stiffness = 210e9 * 2.2e-5;
  const double slope = across * 1.15 * 1.15 / (2 * stiffness);
  const double sag = across * std::pow(1.15, 3) / (3 * stiffness) * std::sin(20 * M_PI / 180);
  EXPECT_NEAR(drop("elbow.json") - drop("weight.json"),
              -(5000 * 0.393 / 3.3e6 * 1.741 + slope * 1.348 + sag), 3e-5);
}

TEST(FixedPointMethod, AgreesWithNewtonsAndSaysWhatItCannotDo) {
  const std::string held = "deflect data/robots/orthoglide.yaml --at 0,0,0 --move 0.5,0.2,0 ";
  ASSERT_EQ(kinetostat(held + "--json newton.json").code, 0);
  const Outcome outcome = kinetostat(held + "--method fixed-point --json fixed.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Fixed-point iteration: eq. 10 was solved"));
  const auto force = [](const char* file, const char* result) {
    return io::read_json(working_folder() / file)[result]["wrench"]["force"][0].get<double>();
  };
  const double newton = force("newton.json", "equilibrium");
  EXPECT_NEAR(force("fixed.json", "fixed_point"), newton, 1e-6 * newton);
  const Outcome refused =
      kinetostat("deflect data/robots/delta.yaml --wrench 0,0,-1 --method fixed-point");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("does not treat bodies between base and platform"));
  EXPECT_EQ(kinetostat(held + "--method picard").code, 2);
}

}  // namespace
}  // namespace kinetostat::compensate_test
