// What 'adopt' writes has the error that the diagnosis showed.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::apps::adopt_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

io::Json result(const std::string& name) { return io::read_json(working_folder() / name); }

double last_bar(const io::Json& diagnosis) {
  for (const io::Json& stage : diagnosis["waterfall"])
    if (stage["name"] == "as adopted") return stage["whitened"];
  ADD_FAILURE() << "no stage 'as adopted'";
  return std::nan("");
}

// A copy of a folder of measurements with the first of its readings.
std::string with_first_readings(const std::string& folder, std::size_t count) {
  const std::filesystem::path copy = working_folder() / "first_readings";
  std::filesystem::remove_all(copy);
  std::filesystem::copy(working_folder() / folder, copy);
  const std::string table = io::read_text(copy / "readings.csv");
  std::size_t end = 0;
  for (std::size_t line = 0; line <= count; ++line) end = table.find('\n', end) + 1;
  io::write_atomically(copy / "readings.csv", table.substr(0, end));
  return "first_readings/";
}

// What readings have determined, with the correlations of the fit, is as certain as they made it.
void expect_uncertain_results(const std::string& robot) {
  EXPECT_THAT(io::read_text(working_folder() / robot), HasSubstr("\ncorrelations:\n"));
  const Outcome outcome = kinetostat("stiffness " + robot + " -q --json adopted.stiffness.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::Json uncertainty = result("adopted.stiffness.json")["uncertainty"];
  double sum = 0;
  for (const io::Json& source : uncertainty["budget"]) sum += source["share"].get<double>();
  EXPECT_NEAR(sum, 1, 1e-9);
}

class ShippedCampaign : public testing::TestWithParam<const char*> {};

TEST_P(ShippedCampaign, AdoptedAsShown) {
  std::string folder = fmt::format("data/measurements/{}/", GetParam());
  std::string more;
  if (folder.find("orthoglide") != std::string::npos) {  // equilibria of closed chains take time
    folder = with_first_readings(folder, 96);
    more = " --effects clearance,friction,preload";
  }
  const std::string campaign = folder + "campaign.yaml", name = GetParam();
  ASSERT_EQ(kinetostat(fmt::format("diagnose {} -q -o {}.json{}", campaign, name, more)).code, 0);
  ASSERT_EQ(
      kinetostat(fmt::format("adopt {}robot.yaml {}.json -o {}.yaml", folder, name, name)).code, 0);
  const Outcome compared =
      kinetostat(fmt::format("compare {0}.yaml {1} -q --json {0}.after.json", name, campaign));
  ASSERT_EQ(compared.code, 0) << compared.err;
  const double shown = last_bar(result(name + ".json"));
  EXPECT_NEAR(result(name + ".after.json")["as_designed"]["error_over_noise"].get<double>(), shown,
              5e-4 * shown);
  expect_uncertain_results(name + ".yaml");
  ASSERT_EQ(kinetostat(fmt::format("revert {}.yaml -q", name)).code, 0);
  EXPECT_EQ(io::read_text(working_folder() / (name + ".yaml")),
            io::read_text(working_folder() / (folder + "robot.yaml")));
}

INSTANTIATE_TEST_SUITE_P(All, ShippedCampaign,
                         testing::Values("arm_hysteresis", "arm_thermal_day", "six_axis_balancer",
                                         "orthoglide_clearance"),
                         [](const auto& campaign) { return campaign.param; });

// Beside nothing at all: the calibrated model, if that is asked for.
TEST(Adopt, WritesTheCalibratedModelWithoutAnEffect) {
  const std::string folder = "data/measurements/arm_nothing_hidden/";
  ASSERT_EQ(kinetostat("diagnose " + folder + "campaign.yaml -q -o nothing.json").code, 0);
  const Outcome refused = kinetostat("adopt " + folder + "robot.yaml nothing.json -o nothing.yaml");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, HasSubstr("--stiffnesses-only"));
  const Outcome adopted =
      kinetostat("adopt " + folder + "robot.yaml nothing.json --stiffnesses-only -o nothing.yaml");
  ASSERT_EQ(adopted.code, 0) << adopted.err;
  const auto compared = [&](const std::string& robot) {
    EXPECT_EQ(
        kinetostat("compare " + robot + " " + folder + "campaign.yaml -q --json after.json").code,
        0);
    return result("after.json");
  };
  const double fitted =
      compared(folder + "robot.yaml")["refitted"]["error_over_noise"].get<double>();
  EXPECT_NEAR(compared("nothing.yaml")["as_designed"]["error_over_noise"].get<double>(), fitted,
              5e-4 * fitted);
}

// What is not of the robot says so when it is written into a robot file.
TEST(Adopt, SaysWhatIsOfTheMeasurementOnly) {
  const std::string folder = "data/measurements/arm_nothing_hidden/";
  std::string plan = "session,cycle,time,q1,q2,q3,q4,q5,q6,fx,fy,fz\n";
  for (int i = 0; i < 48; ++i) {
    const auto wave = [i](double k) { return std::sin(k * (i / 4 + 1)); };
    const double share = i % 4 / 3.0;
    plan +=
        fmt::format("monday,{},{},{},{},{},{},{},{},{},{},{}\n", i / 4 + 1, 60 * i, 60 * wave(1.1),
                    40 * wave(1.7), 40 * wave(2.3), 90 * wave(0.9), 60 * wave(1.3), 90 * wave(2.9),
                    400 * share * wave(0.7), 400 * share * wave(1.9), 400 * share * wave(2.6));
  }
  io::write_atomically(working_folder() / "measured_plan.csv", plan);
  const auto adopted = [&](const std::string& effect) {
    EXPECT_EQ(kinetostat("simulate " + folder +
                         "robot.yaml --plan measured_plan.csv "
                         "--noise-translation '5 um' -o measured --quiet " +
                         effect)
                  .code,
              0);
    EXPECT_EQ(kinetostat("diagnose measured/campaign.yaml -q -o measured.json "
                         "--effects application_point,target_slip,friction")
                  .code,
              0);
    return kinetostat("adopt " + folder + "robot.yaml measured.json -o measured.yaml").out;
  };
  EXPECT_THAT(adopted("--effect application_point --at load --size 'x=50 mm,y=-80 mm,z=30 mm'"),
              HasSubstr("not of the robot"));
  EXPECT_THAT(adopted("--effect target_slip --at sensor "
                      "--size 'x=0.3 mm,y=0.2 mm,session=1,time=1500 s'"),
              HasSubstr("compare other readings"));
}

}  // namespace
}  // namespace kinetostat::apps::adopt_test
