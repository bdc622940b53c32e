// Where something exceeds the detection threshold, but nothing is more probable.
#include <algorithm>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/report/screen/diagnosis.h"

#include "calibration/laboratory.h"
#include "calibration/load_loops.h"

namespace kinetostat::calibration::doubt_test {
namespace {

using test::Laboratory;
using testing::HasSubstr;

const std::vector<std::string> kinds = {"friction", "hardening", "creep"};

std::string slide() {
  return "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n"
         "  cell:\n    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
         "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";
}

// The same noise each time, and friction of this force [N]: k sigma is 0.5 N.
struct Said {
  explicit Said(double force) {
    if (force > 0)
      laboratory.hide("friction", "q", fmt::format("force={} N,presliding=3 um", force));
    campaign = laboratory.measure(test::loops(2));
    diagnosis = laboratory.diagnose(campaign, kinds);
  }
  Laboratory laboratory{slide()};
  Campaign campaign;
  Diagnosis diagnosis;
};

// 0: nothing exceeds the threshold, 1: something does that is less probable, 2: it is listed,
// 3: identified.
int stage_of(const Diagnosis& d) {
  if (d.verdict == Verdict::identified) return 3;
  if (d.verdict != Verdict::none_needed) return 2;
  return d.doubted ? 1 : 0;
}

double force_in_doubt() {
  for (double force = 0.1; force < 1.5; force += 0.05)
    if (stage_of(Said(force).diagnosis) == 1) return force;
  return 0;
}

// What grows out of the noise goes through these stages in their order.
TEST(Doubt, LiesBetweenNothingAndAName) {
  int last = 0;
  bool in_doubt = false;
  for (double force = 0; force < 1.6; force += 0.1) {
    const Said said(force);
    const int stage = stage_of(said.diagnosis);
    EXPECT_GE(stage, last) << force;
    last = std::max(last, stage);
    if (!said.diagnosis.doubted) continue;
    in_doubt = true;
    const Decision& decision = said.diagnosis.doubted->decision;
    EXPECT_TRUE(said.diagnosis.found.empty());
    ASSERT_FALSE(decision.answers.empty());
    EXPECT_GE(decision.nothing, decision.answers[0].probability);
    EXPECT_LE(said.diagnosis.doubted->false_alarm_chance, 0.05);
    // The model is that without it.
    EXPECT_EQ(said.diagnosis.after->statistic, said.diagnosis.before->statistic);
  }
  EXPECT_TRUE(in_doubt);
  EXPECT_EQ(last, 3);
}

TEST(Doubt, IsSaidAndPlannedFor) {
  const double force = force_in_doubt();
  ASSERT_GT(force, 0);
  Said said(force);
  const Diagnosis& d = said.diagnosis;
  EXPECT_THAT(report::headline(said.laboratory.robot(), said.campaign, d),
              HasSubstr("the most probable answer is that nothing is missing ("));
  EXPECT_THAT(report::verdict_in_short(said.laboratory.robot(), d),
              HasSubstr("nothing, most probably ("));
  EXPECT_THAT(report::text(said.laboratory.robot(), said.campaign, d),
              HasSubstr("perhaps one of: "));
  const DiagnosisRecord record = said.laboratory.recorded(said.campaign, d);
  ASSERT_TRUE(record.doubted);
  EXPECT_EQ(record.doubted->nothing, d.doubted->decision.nothing);
  const PlanQuestion question = question_of(said.laboratory.robot(), record, {});
  ASSERT_FALSE(question.open.empty());
  EXPECT_EQ(question.open[0].candidate.name(), d.doubted->candidate.name());
  EXPECT_TRUE(question.perhaps_nothing);
  EXPECT_TRUE(question.present.empty());
  double sum = question.nothing;
  for (const OpenCandidate& open : question.open) sum += open.probability;
  EXPECT_LE(sum, 1);
  common::Progress silent;
  const Plan p = plan(said.laboratory.robot(), said.campaign, question, {.minutes = 60}, 2, silent);
  ASSERT_FALSE(p.blocks.empty());
  const auto is_against_nothing = [](const PlannedSplit& s) { return s.b == "nothing more"; };
  EXPECT_TRUE(std::any_of(p.splits.begin(), p.splits.end(), is_against_nothing));
}

}  // namespace
}  // namespace kinetostat::calibration::doubt_test
