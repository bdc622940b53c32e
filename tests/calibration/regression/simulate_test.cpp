#include "kinetostat/calibration/regression/simulate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

#include "calibration/synthetic.h"

namespace kinetostat::calibration::simulate_test {
namespace {

using testing::HasSubstr;

const std::string loads = "# a comment\nid,x,y,z,fx,fy,fz\n\na,0,0,0,100,0,0\nb,50,0,0,0,-200,50\n";

std::filesystem::path plan(const std::string& csv) {
  return test::write_campaign("", csv).parent_path() / "readings.csv";
}

SimulatedCampaign simulated(const SimulationOptions& options, const std::string& csv = loads) {
  common::Progress silent;
  return simulate(test::orthoglide(), "robot.yaml", plan(csv), options, silent);
}

Comparison against_the_model(const SimulatedCampaign& made) {
  vjm::Robot robot = test::orthoglide();
  robot.uncertain.clear();
  std::string yaml = made.yaml;  // the robot is given in memory
  yaml.erase(yaml.find("robot: "),
             yaml.find('\n', yaml.find("robot: ")) + 1 - yaml.find("robot: "));
  return test::compare_files(robot, test::write_campaign(yaml, made.readings));
}

TEST(Simulate, WithoutNoiseTheModelIsExact) {
  for (const auto kind : {DisplacementKind::difference, DisplacementKind::absolute})
    EXPECT_TRUE(against_the_model(simulated({.displacement = kind})).nominal.is_exact);
}

TEST(Simulate, TheNoiseIsTheStatedOne) {
  std::string csv = "x,y,z,fx\n";
  for (int i = 0; i < 300; ++i) csv += fmt::format("0,0,0,{}\n", i);
  const Comparison c = against_the_model(
      simulated({.translation_noise = 5e-6, .rotation_noise = 2e-5, .seed = 3}, csv));
  const ChiSquareTest& test = c.nominal.chi_square.value();
  EXPECT_EQ(test.degrees_of_freedom, 1800);
  EXPECT_GT(test.p_value, 1e-3);
  EXPECT_GT(test.lower_p_value, 1e-3);
}

TEST(Simulate, TheSeedAloneDecides) {
  const SimulationOptions one{.translation_noise = 1e-5, .seed = 1};
  SimulationOptions many = one, other = one;
  many.threads = 4;
  other.seed = 2;
  EXPECT_EQ(simulated(one).readings, simulated(many).readings);
  EXPECT_NE(simulated(one).readings, simulated(other).readings);
}

TEST(Simulate, KeepsThePlanAndSaysWhatItsReadingsAre) {
  const SimulatedCampaign made = simulated({.components = {true, false, true}, .seed = 7});
  EXPECT_THAT(made.readings, HasSubstr("# a comment\nid,x,y,z,fx,fy,fz,dx,dz\n\na,0,0,0,100,0,0,"));
  EXPECT_THAT(made.yaml, HasSubstr("proves nothing"));
  EXPECT_THAT(made.yaml, HasSubstr("seed 7"));
}

TEST(Simulate, SemicolonsStaySemicolons) {
  EXPECT_THAT(simulated({.components = {true}}, "x;y;z;fx\n0;0;0;0\n").readings,
              HasSubstr("x;y;z;fx;dx\n0;0;0;0;"));
}

TEST(Simulate, RefusesAPlanThatHasDisplacements) {
  try {
    simulated({}, "x,y,z,fx,dx\n0,0,0,1,1\n");
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("readings.csv:1: dx: a plan has no displacements"));
  }
}

}  // namespace
}  // namespace kinetostat::calibration::simulate_test
