// kinetostat fleet as its users meet it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::fleet_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;
using testing::Not;

TEST(Fleet, NamesTheRobotThatHasWorn) {
  const Outcome outcome =
      kinetostat("fleet data/fleet/fleet.yaml --json fleet.json --html fleet.html");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("outside the control limits is S-09 of 2025-05-15."));
  EXPECT_THAT(outcome.out, HasSubstr("gap of clearance at rho is 9 um, above its limit"));
  const io::Json json = io::read_json(working_folder() / "fleet.json");
  ASSERT_EQ(json["series"].size(), 2u);
  for (const io::Json& series : json["series"]) {
    EXPECT_EQ(series["values"].size(), 12u);
    const bool is_gap = series["name"] == "gap of clearance at rho";
    EXPECT_EQ(series["outside"].size(), is_gap ? 1u : 0u);
    double sum = 0;
    for (const io::Json& value : series["values"]) sum += value["value"].get<double>();
    EXPECT_NEAR(series["limits"]["mean"].get<double>(), sum / 12, 1e-12);
  }
  EXPECT_TRUE(std::filesystem::exists(working_folder() / "fleet.html"));
}

// One robot over three years, by its diagnoses: in the order of their dates, whatever that of the
// list; serial number and date of the campaign count where the list has none.
TEST(Fleet, OfDiagnosesIsInTheOrderOfTheirDates) {
  const std::string diagnosis = "measurements/arm_backlash_soft_base/campaign.yaml";
  ASSERT_EQ(kinetostat("diagnose data/" + diagnosis + " --draws 99 -o d.json").code, 0);
  io::Json json = io::read_json(working_folder() / "d.json");
  const double gap = json["found"][0]["values"][0].get<double>();
  for (const auto& [name, factor] : {std::pair("b", 1.5), {"a", 1.0}, {"c", 1.1}}) {
    json["found"][0]["values"][0] = factor * gap;
    json["serial"] = "arm 7";
    io::write_json(working_folder() / (std::string(name) + ".json"), json);
  }
  io::write_atomically(working_folder() / "list.yaml",
                       "kinetostat: 1\nfleet: arm 7\nrobots:\n  - {date: 2025-03-01, file: "
                       "b.json}\n  - {date: 2023-03-01, file: a.json}\n  - {serial: other, date: "
                       "2024-03-01, file: c.json}\n");
  ASSERT_EQ(kinetostat("fleet list.yaml --json out.json").code, 0);
  const io::Json fleet = io::read_json(working_folder() / "out.json");
  EXPECT_EQ(fleet["members"][0]["date"], "2023-03-01");
  EXPECT_EQ(fleet["members"][0]["serial"], "arm 7");
  EXPECT_EQ(fleet["members"][1]["serial"], "other");
  const io::Json& series = fleet["series"][0];
  EXPECT_THAT(series["name"].get<std::string>(), HasSubstr("gap of clearance at"));
  for (const auto& [at, factor] : {std::pair(0, 1.0), {1, 1.1}, {2, 1.5}})
    EXPECT_DOUBLE_EQ(series["values"][at]["value"].get<double>(), factor * gap);
  EXPECT_DOUBLE_EQ(series["limits"]["mean_moving_range"].get<double>(), 0.25 * gap);
  const Outcome few = kinetostat("fleet a.json b.json");
  EXPECT_THAT(few.out, HasSubstr("no quantity has the 3 values"));
}

TEST(Fleet, NamesMistakes) {
  const auto message = [](const std::string& robots) {
    io::write_atomically(working_folder() / "wrong.yaml",
                         "kinetostat: 1\nfleet: arms\nrobots:\n  - " + robots + "\n");
    const Outcome outcome = kinetostat("fleet wrong.yaml");
    EXPECT_EQ(outcome.code, 3) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(message("{date: 2025-13-01, file: data/fleet/slide_01.yaml}"),
              HasSubstr("wrong.yaml:4: robots[0].date: this is no date"));
  EXPECT_THAT(message("{date: 2024-02-30, file: data/fleet/slide_01.yaml}"),
              HasSubstr("this is no date"));
  io::write_atomically(working_folder() / "none.yaml", "kinetostat: 1\nfleet: a\nrobots: []\n");
  EXPECT_THAT(kinetostat("fleet none.yaml").err,
              HasSubstr("none.yaml:3: robots: the list is empty"));
  EXPECT_THAT(message("{date: 1.5.2025, file: data/fleet/slide_01.yaml}"),
              HasSubstr("Write year, month, day"));
  EXPECT_THAT(message("{serail: 1, file: x.yaml}"), HasSubstr("Did you mean 'serial'"));
  EXPECT_THAT(message("{file: nowhere.json}"), HasSubstr("nowhere.json"));
  for (const char* few : {"1", "2"})
    EXPECT_EQ(kinetostat(fmt::format("fleet data/fleet/fleet.yaml --baseline {}", few)).code, 2);
}

}  // namespace
}  // namespace kinetostat::fleet_test
