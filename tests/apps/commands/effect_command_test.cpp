// The catalogue, effects of a robot file's own, and what they do to readings, as users meet them.
#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::effect_command_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

void write_robot() {
  io::write_atomically(working_folder() / "own.yaml",
                       "kinetostat: 1\nname: own\nunits: {length: mm, force: N, angle: deg}\n"
                       "chain_types:\n  cell:\n"
                       "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
                       "manipulator: {chain: cell}\n"
                       "effect_kinds:\n  cable_drag:\n    force: \"a * tanh(d / w)\"\n"
                       "    summary: the cable resists\n    parameters:\n"
                       "      a: {unit: N, between: [-500, 500], prior: 60}\n"
                       "      w: {unit: um, between: [1, 1000], prior: 50, none: 50}\n");
  io::write_atomically(working_folder() / "own.csv",
                       "id,cycle,step,time,fz\na,1,1,0,0\nb,1,2,60,500\nc,1,3,120,0\n"
                       "d,1,4,180,-500\ne,1,5,240,0\nf,1,6,300,200\ng,1,7,360,-200\n");
}

TEST(EffectCommand, ListsAndShowsEffectsOfTheRobotFile) {
  write_robot();
  EXPECT_THAT(kinetostat("effect list own.yaml -q").out, HasSubstr("cable_drag"));
  EXPECT_THAT(kinetostat("effect list -q").out, testing::Not(HasSubstr("cable_drag")));
  const Outcome shown = kinetostat("effect show cable_drag own.yaml -q --json shown.json");
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("a * tanh(d / w)"));
  EXPECT_THAT(shown.out, HasSubstr("prior +- 60"));
  EXPECT_THAT(shown.out, HasSubstr("cell.q"));
  EXPECT_EQ(io::read_json(working_folder() / "shown.json")["effect"]["places"][0], "cell.q");
  // Nothing between base and joint could expand, and an error of geometry can be at either end.
  ASSERT_EQ(kinetostat("effect show thermal_expansion own.yaml -q --json expands.json").code, 0);
  ASSERT_EQ(kinetostat("effect show geometric_error own.yaml -q --json misplaced.json").code, 0);
  const auto has_base = [](const char* file) {
    const auto places = io::read_json(working_folder() / file)["effect"]["places"];
    return std::find(places.begin(), places.end(), "cell.base") != places.end();
  };
  EXPECT_FALSE(has_base("expands.json"));
  EXPECT_TRUE(has_base("misplaced.json"));
  const Outcome unknown = kinetostat("effect show cable_drag -q");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("effect list ROBOT.yaml"));
}

// F = k d + a tanh(d / w), by hand: what simulate says that it changes, and at which reading.
TEST(EffectCommand, SimulateShowsWhatAnEffectWouldDo) {
  write_robot();
  const Outcome outcome = kinetostat(
      "simulate own.yaml --plan own.csv --effect cable_drag --at q --size \"a=100 N,w=50 um\" "
      "--noise-translation 1um -o drag --json drag.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Hidden effect cable_drag at q"));
  double d = 0.4e-3;
  for (int i = 0; i < 50; ++i) {
    const double t = std::tanh(d / 5e-5);
    d -= (1e6 * d + 100 * t - 500) / (1e6 + 100 / 5e-5 * (1 - t * t));
  }
  const io::Json trace = io::read_json(working_folder() / "drag.json")["hidden"];
  EXPECT_EQ(trace["changes"][2]["component"], "dz");
  EXPECT_NEAR(trace["changes"][2]["max"].get<double>(), 0.5e-3 - d, 1e-12);
  EXPECT_EQ(trace["changes"][2]["worst_reading"], "b");
  // It is in the readings: diagnose, with the user's effect as its only candidate, finds it.
  EXPECT_EQ(kinetostat("diagnose own.yaml drag/campaign.yaml -q --effects cable_drag --draws 99 "
                       "-o found.json")
                .code,
            0);
  EXPECT_EQ(io::read_json(working_folder() / "found.json")["found"][0]["effect"], "cable_drag");
}

TEST(EffectCommand, SimulateNeedsAPlaceAndASize) {
  write_robot();
  const std::string simulate = "simulate own.yaml --plan own.csv -o x --effect ";
  EXPECT_THAT(kinetostat(simulate + "clearance --at q").err, HasSubstr("--size"));
  EXPECT_THAT(kinetostat(simulate + "clearence --at q --size 1um").err,
              HasSubstr("did you mean 'clearance'"));
  EXPECT_THAT(kinetostat(simulate + "clearance --at p --size 1um").err,
              HasSubstr("'p' is no joint of this robot"));
  for (const char* bad : {"1kg", "-1um", "nan"})
    EXPECT_NE(kinetostat(simulate + "clearance --at q --size " + bad).code, 0) << bad;
}

// The load cell's noise is in the readings, and in the campaign file that tells of it.
TEST(EffectCommand, SimulateDisturbsTheWrench) {
  write_robot();
  ASSERT_EQ(
      kinetostat("simulate own.yaml --plan own.csv --noise-translation 0.01um --noise-force 5N "
                 "--noise-wrench 1% --components dz -o noisy")
          .code,
      0);
  EXPECT_THAT(io::read_text(working_folder() / "noisy/campaign.yaml"),
              HasSubstr("wrench_noise: {force: 5 N, share: 0.01}"));
  ASSERT_EQ(kinetostat("compare noisy/campaign.yaml -q --json noisy.json").code, 0);
  const io::Json test = io::read_json(working_folder() / "noisy.json")["as_designed"]["chi_square"];
  EXPECT_GT(test["reduced"].get<double>(), 0.05);
  EXPECT_LT(test["reduced"].get<double>(), 4);
}

// Diagnose, plan, simulate the plan as it is, diagnose with the score of the plan.
TEST(PlanCommand, GoesTheWholeWay) {
  write_robot();
  io::write_atomically(working_folder() / "up.csv",
                       "id,session,cycle,step,time,fz\na,f,1,1,0,200\nb,f,1,2,60,400\n"
                       "c,f,2,1,120,600\nd,f,2,2,180,800\n");
  ASSERT_EQ(kinetostat("simulate own.yaml --plan up.csv --noise-translation 1um --components dz "
                       "--effect friction --at q --size \"force=50 N,presliding=5 um\" -o up")
                .code,
            0);
  const std::string few = " --effects friction,clearance --draws 99 -q ";
  const Outcome first = kinetostat("diagnose up/campaign.yaml -o d.json" + few);
  const Outcome plan = kinetostat(
      "plan up/campaign.yaml --diagnosis d.json --minutes 40 -q -o plan.csv --json plan.json");
  ASSERT_EQ(plan.code, 0) << plan.err;
  const io::Json json = io::read_json(working_folder() / "plan.json");
  EXPECT_LE(json["minutes"].get<double>(), 40 + 10);
  EXPECT_FALSE(json["cycles"].empty());
  EXPECT_EQ(kinetostat("simulate own.yaml --plan plan.csv --noise-translation 1um --components dz "
                       "--effect friction --at q --size \"force=50 N,presliding=5 um\" -o planned")
                .code,
            0);
  const Outcome scored =
      kinetostat("diagnose planned/campaign.yaml --plan plan.json -o e.json" + few);
  EXPECT_THAT(scored.out, HasSubstr("What the plan promised"));
  EXPECT_TRUE(io::read_json(working_folder() / "e.json").contains("plan"));

  // A diagnosis of other readings, something that is no plan, and effects that nobody knows.
  EXPECT_EQ(kinetostat("plan planned/campaign.yaml --diagnosis d.json -q").code, 3);
  EXPECT_EQ(kinetostat("diagnose planned/campaign.yaml --plan d.json" + few).code, 3);
  EXPECT_EQ(kinetostat("plan up/campaign.yaml --show frction --diagnosis d.json -q").code, 2);
  EXPECT_EQ(kinetostat("plan up/campaign.yaml --most-force -3 --diagnosis d.json -q").code, 2);
}

}  // namespace
}  // namespace kinetostat::effect_command_test
