// What a refit of several stiffnesses may have taken up: one cause behind them all.
#include "kinetostat/calibration/diagnosis/common_cause.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/calibration/design/plan_question.h"

#include "calibration/laboratory.h"

namespace kinetostat::calibration::common_cause_test {
namespace {

using test::Laboratory;

// An arm of three drives, all of unsure stiffness, pushed two ways at six postures.
class CommonCauseTest : public testing::Test {
 protected:
  static std::string arm(double softer, double stiffer) {
    return fmt::format(
        "kinetostat: 1\nname: arm\nunits: {{length: mm, force: N, angle: deg}}\nchain_types:\n  "
        "arm:\n"
        "    - actuator: {{name: q1, axis: Rz, stiffness: {} N m/rad}}\n    - tool: [400, 0, 0]\n"
        "    - actuator: {{name: q2, axis: Rz, home: 40, stiffness: {} N m/rad}}\n"
        "    - tool: [300, 0, 0]\n"
        "    - actuator: {{name: q3, axis: Rz, home: 40, stiffness: 1.0e4 N m/rad}}\n"
        "    - tool: [200, 0, 0]\nmanipulator: {{chain: arm}}\n"
        "uncertain:\n  - {{stiffness: q1}}\n  - {{stiffness: q2}}\n  - {{stiffness: q3}}\n",
        4e4 / softer, 2e4 * stiffer);
  }
  static std::string plan() {
    std::string rows = "id,q1,q2,q3,fx,fy\n";
    int id = 0;
    for (const int q1 : {0, 50})
      for (const int q2 : {20, 70, 110})
        for (const int force : {50, -50, 90, -90})
          for (const bool along : {true, false})
            rows += fmt::format("r{},{},{},{},{},{}\n", id++, q1, q2, 100 - q2, along ? force : 0,
                                along ? 0 : force);
    return rows;
  }
  static Campaign measure(Laboratory& real) {
    real.options().translation_noise = 2e-6;
    real.options().components = {true, true, false, false, false, false};
    return real.measure(plan());
  }
  static Diagnosis diagnose(const Campaign& campaign, const Laboratory& model) {
    return model.diagnose(campaign, {"wrench_gain", "clearance", "joint_compliance", "payload"});
  }
};

TEST_F(CommonCauseTest, AGainOfTheLoadCellMakesAllSpringsSofterAtOnce) {
  Laboratory arm(CommonCauseTest::arm(1, 1));
  arm.hide("wrench_gain", "load", "gain=1.05");
  const Diagnosis d = diagnose(measure(arm), arm);
  EXPECT_EQ(d.verdict, Verdict::inconclusive);
  ASSERT_TRUE(d.common_cause.has_value());
  EXPECT_EQ(d.common_cause->candidate.name(), "wrench_gain at load");
  EXPECT_NEAR(d.common_cause->candidate.effect.values[0], 1.05, 0.005);
  EXPECT_GT(d.common_cause->test.p_value, 0.001);
}

// One spring softer and another one stiffer than nominal: no single cause does that; one spring
// alone needs none.
TEST_F(CommonCauseTest, StiffnessesThatAreWrongNeedNoOtherCause) {
  for (const double stiffer : {1.15, 1.0}) {
    Laboratory real(arm(1.1, stiffer));
    const Laboratory model(arm(1, 1));
    const Diagnosis d = diagnose(measure(real), model);
    EXPECT_EQ(d.verdict, Verdict::none_needed);
    EXPECT_FALSE(d.common_cause.has_value());
  }
}

TEST_F(CommonCauseTest, AModelThatIsRightNeedsNone) {
  Laboratory arm(CommonCauseTest::arm(1, 1));
  const Diagnosis d = diagnose(measure(arm), arm);
  EXPECT_EQ(d.verdict, Verdict::none_needed);
  EXPECT_FALSE(d.common_cause.has_value());
}

// The plan asks for readings that distinguish the one from the other.
TEST_F(CommonCauseTest, ThePlanAsksForKnownWeights) {
  Laboratory arm(CommonCauseTest::arm(1, 1));
  arm.hide("wrench_gain", "load", "gain=1.05");
  const Campaign campaign = measure(arm);
  const Diagnosis d = diagnose(campaign, arm);
  const PlanQuestion question = question_of(arm.robot(), arm.recorded(campaign, d), {});
  ASSERT_EQ(question.open.size(), 1u);
  EXPECT_EQ(question.open[0].candidate.name(), "wrench_gain at load");
  common::Progress silent;
  const Plan p =
      kinetostat::calibration::plan(arm.robot(), campaign, question, {.minutes = 60}, 2, silent);
  ASSERT_FALSE(p.splits.empty());
  EXPECT_GT(p.splits[0].separation, 4);
  EXPECT_TRUE(p.asks_for_weights);
  for (const Reading& reading : p.readings.readings) EXPECT_TRUE(reading.load.moment.isZero(0));
}

}  // namespace
}  // namespace kinetostat::calibration::common_cause_test
