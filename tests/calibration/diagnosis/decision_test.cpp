#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/diagnosis/found_effect.h"

namespace kinetostat::calibration::decision_test {
namespace {

using testing::ElementsAre;

RankedCandidate fitted(const std::string& kind, const std::string& at, double log_evidence,
                       double discriminability = 20) {
  RankedCandidate ranked;
  ranked.candidate.effect.kind = vjm::effect_kind(kind);
  ranked.candidate.effect.at = at;
  ranked.fit = CandidateFit{};
  ranked.fit->log_evidence = log_evidence;
  ranked.fit->discriminability = discriminability;
  return ranked;
}

// Nothing missing is out of the question, unless a test says otherwise.
DiagnosisStep round_of(std::vector<RankedCandidate> ranking, double without = -100) {
  DiagnosisStep step;
  step.ranking = std::move(ranking);
  step.log_evidence_without = without;
  step.free_form.log = -50;
  step.free_form.over = SmoothOver::time;
  return step;
}

TEST(Decision, LawsOfOneCurveAddUp) {
  const Decision d =
      decide(round_of({fitted("clearance", "q1", 0), fitted("piecewise_stiffness", "q1", -0.3),
                       fitted("hardening", "q1", -1), fitted("creep", "q1", -20)}));
  ASSERT_TRUE(d.is_identified);
  ASSERT_EQ(d.answers.size(), 1u);
  EXPECT_THAT(d.answers[0].places, ElementsAre("q1"));
  EXPECT_EQ(d.answers[0].effect_class, "stiffens or softens under load, or backlash");
  EXPECT_GT(d.answers[0].probability, 0.999);
  ASSERT_EQ(d.answers[0].laws.size(), 3u);
  // Shares by hand: e^0, e^-0.18, e^-0.6 of their sum.
  const double sum = 1 + std::exp(-0.18) + std::exp(-0.6);
  EXPECT_NEAR(d.answers[0].laws[0].share, 1 / sum, 1e-12);
  EXPECT_NEAR(d.answers[0].laws[2].share, std::exp(-0.6) / sum, 1e-12);
}

TEST(Decision, OneSidedLawsAreOfTheSameCurve) {
  const Decision d = decide(
      round_of({fitted("opening_contact", "q1", 0), fitted("directional_stiffness", "q1", -0.5),
                fitted("clearance", "q1", -1), fitted("load_friction", "q1", -20)}));
  ASSERT_TRUE(d.is_identified);
  EXPECT_EQ(d.answers[0].laws.size(), 3u);
}

// Beside what was found later another one may do its work better, also where the round saw no need
// to fit it: then by what the model with it leaves.
TEST(Replacement, IsByWhatFitsBetterBesideTheOthers) {
  DiagnosisStep step = round_of({fitted("clearance", "q2", -10), fitted("clearance", "q1", -12)});
  step.ranking[0].fit->squared_error = 394;
  step.ranking[1].fit->squared_error = 399;
  const FoundEffect found{.candidate = step.ranking[1].candidate, .deviations = {}, .decision = {}};
  EXPECT_FALSE(is_replaced(step, found, 399));  // not decidedly likelier
  step.ranking[1].fit->log_evidence = -15;
  EXPECT_TRUE(is_replaced(step, found, 399));
  step.ranking[1].fit->squared_error = 393;
  EXPECT_FALSE(is_replaced(step, found, 393));   // it fits better
  step.ranking[0].fit->degrees_of_freedom = 90;  // with six values, where one does
  step.ranking[1].fit->degrees_of_freedom = 85;
  EXPECT_TRUE(is_replaced(step, found, 393));
  step.ranking[1].fit.reset();
  EXPECT_FALSE(is_replaced(step, found, 402));
  EXPECT_TRUE(is_replaced(step, found, 404));
}

// Of the laws of one answer the likeliest is named, even where its fit is no better.
TEST(Replacement, TakesTheLikeliestLawOfAnAnswer) {
  DiagnosisStep step =
      round_of({fitted("friction", "q1", -10), fitted("load_friction", "q1", -11)});
  step.ranking[0].fit->squared_error = 400;
  step.ranking[1].fit->squared_error = 399;
  const FoundEffect found{.candidate = step.ranking[1].candidate, .deviations = {}, .decision = {}};
  EXPECT_TRUE(is_replaced(step, found, 399));
  step.ranking[1].fit->log_evidence = -10.5;  // as good as two to one
  EXPECT_FALSE(is_replaced(step, found, 399));
  step.ranking[0] = fitted("creep", "q1", -10);  // another class
  step.ranking[1].fit->log_evidence = -11;
  EXPECT_FALSE(is_replaced(step, found, 399));
}

// What is still missing beside one that was found, in a round with a decided winner.
DiagnosisStep next_round(double p_value) {
  DiagnosisStep step = round_of({fitted("clearance", "q2", 0), fitted("creep", "q1", -30)});
  step.beside = {"friction at q1"};
  step.indistinguishable = {0};
  step.max_score.p_value = p_value;
  step.ranking[0].fit->log_score_gain = 40;
  step.ranking[0].fit->log_score_deviation = 10;
  step.ranking[0].fit->discriminability = 25;
  return step;
}

TEST(Finding, IsAPartWhereASmoothErrorDoesBetter) {
  DiagnosisStep step = next_round(0.002);
  EXPECT_EQ(finding(step, {}), Finding::effect);
  step.free_form_probability = 0.9;
  EXPECT_EQ(finding(step, {}), Finding::part);
  step.ranking[0].fit->log_score_gain = 5;  // within its deviation
  EXPECT_EQ(finding(step, {}), Finding::nothing);
}

// Near the detection threshold the evidence decides, but not of what would be one more.
TEST(Finding, OfTheFirstEffectMayComeNearTheThreshold) {
  DiagnosisStep step = next_round(0.08);
  EXPECT_EQ(finding(step, {}), Finding::nothing);
  step.beside.clear();
  EXPECT_EQ(finding(step, {}), Finding::effect);
  step.ranking[0].fit->log_score_gain = 5;  // within its deviation
  EXPECT_EQ(finding(step, {}), Finding::effect);
  step.log_evidence_without = -3;  // neither predicts nor is far more probable
  EXPECT_EQ(finding(step, {}), Finding::nothing);
  step = next_round(0.12);
  step.beside.clear();
  EXPECT_EQ(finding(step, {}), Finding::nothing);
}

// What is small beside a law that may be wrong: as far as it acts on the same readings.
TEST(Finding, IsNoneThatALawMayGetWrong) {
  DiagnosisStep step = next_round(0.002);
  step.ranking[0].fit->discriminability = 6;
  const auto beside = [](const std::string& kind, const std::string& at, double length) {
    FoundEffect found{.candidate = fitted(kind, at, 0).candidate, .deviations = {}, .decision = {}};
    found.length = length;
    return std::vector<FoundEffect>{found};
  };
  EXPECT_EQ(finding(step, beside("friction", "q1", 50)), Finding::effect);
  EXPECT_EQ(finding(step, beside("friction", "q1", 70)), Finding::nothing);
  EXPECT_EQ(finding(step, beside("sensor_frame", "sensor", 250)), Finding::effect);
  EXPECT_EQ(finding(step, beside("sensor_frame", "sensor", 350)), Finding::nothing);
  step.shared = {0.5};
  EXPECT_EQ(finding(step, beside("friction", "q1", 110)), Finding::effect);
}

// A rest that fades slowly passes for noise that does; evidence has weighed that already.
TEST(Finding, IsNoAlarmWhereTheEvidenceExcludesCorrelatedNoise) {
  DiagnosisStep step = next_round(0.038);
  EXPECT_EQ(finding(step, {}), Finding::nothing);  // with independent noise
  step.takes_rest_for_noise = true;
  EXPECT_EQ(finding(step, {}), Finding::effect);
  step.log_evidence_without = -12;  // no more than e^12 to 1
  EXPECT_EQ(finding(step, {}), Finding::nothing);
  step = next_round(0.2);
  step.takes_rest_for_noise = true;
  EXPECT_EQ(finding(step, {}), Finding::nothing);
}

// A round that did not fit it decides nothing of it.
TEST(Replacement, LeavesTheDecisionOfWhatARoundDidNotFit) {
  const DiagnosisStep before =
      round_of({fitted("friction", "q1", 0), fitted("clearance", "q2", -20)});
  FoundEffect found = found_effect(before);
  confirm(round_of({fitted("clearance", "q2", 0)}), found);
  EXPECT_THAT(found.decision.answers[0].places, ElementsAre("q1"));
  confirm(round_of({fitted("friction", "q2", 0), fitted("friction", "q1", -20)}), found);
  EXPECT_THAT(found.decision.answers[0].places, ElementsAre("q2"));
}

// A law that contains the other is no other answer, however near its predictions are.
TEST(Decision, ALawThatContainsTheOtherLeavesTheAnswerIdentified) {
  const Decision d = decide(
      round_of({fitted("clearance", "q1", 0, 30), fitted("piecewise_stiffness", "q1", -7, 0.5)}));
  ASSERT_TRUE(d.is_identified);
  EXPECT_EQ(d.answers[0].effect_class, "backlash");
}

TEST(Decision, TheClassIsNamedAloneWhereItHoldsTheLevel) {
  const Decision d =
      decide(round_of({fitted("clearance", "q1", 0), fitted("piecewise_stiffness", "q1", -8)}));
  ASSERT_TRUE(d.is_identified);
  EXPECT_EQ(d.answers[0].effect_class, "backlash");
}

// A soft centre that ends at the least stiffness that its law can have is a gap.
TEST(Decision, ALawThatEndsAtABoundStandsForItsRelative) {
  const auto decided = [](double ratio2, const char* relative) {
    RankedCandidate soft = fitted("piecewise_stiffness", "q1", 0);
    soft.fit->values = Eigen::Vector4d(ratio2, 1.5, 1, 4);
    return decide(round_of({soft, fitted(relative, "q1", -20)}));
  };
  const Decision inside = decided(0.06, "clearance");
  EXPECT_EQ(inside.answers.at(0).effect_class, "stiffens or softens under load");
  EXPECT_FALSE(inside.answers[0].laws.at(0).is_at_limit);
  const Decision at_limit = decided(0.05, "clearance");
  ASSERT_TRUE(at_limit.is_identified);
  EXPECT_EQ(at_limit.answers.at(0).effect_class, "backlash");
  EXPECT_EQ(at_limit.answers[0].laws.at(0).effect, "piecewise_stiffness");
  EXPECT_TRUE(at_limit.answers[0].laws[0].is_at_limit);
  EXPECT_NEAR(at_limit.answers[0].probability, inside.answers[0].probability, 1e-12);
  // Where there is no other class, it is what it is.
  EXPECT_EQ(decided(0.05, "hardening").answers.at(0).effect_class,
            "stiffens or softens under load");
}

TEST(Decision, PlacesThatPredictAlikeAreOneAnswer) {
  const Decision alike = decide(round_of(
      {fitted("base_compliance", "base", 0), fitted("bearing_compliance", "q1", -0.5, 1.5)}));
  ASSERT_TRUE(alike.is_identified);
  EXPECT_THAT(alike.answers[0].places, ElementsAre("base", "q1"));
  const Decision apart = decide(round_of(
      {fitted("base_compliance", "base", 0), fitted("bearing_compliance", "q1", -0.5, 9)}));
  EXPECT_FALSE(apart.is_identified);
  EXPECT_TRUE(apart.is_narrowed_down);
  ASSERT_EQ(apart.answers.size(), 2u);
  EXPECT_THAT(apart.answers[1].places, ElementsAre("q1"));
}

// A balancer turns its joint by its angle, as an eccentric gear does: no reading of the platform
// distinguishes them, and more readings of the same kind are no use.
// The d' of the first is its distance from nothing, whatever rounding makes of the evidence.
TEST(Decision, PlacesThatAreTheSameButForRoundingAreOneAnswer) {
  const Decision d = decide(round_of({fitted("geometric_error", "b.end", 0, 495),
                                      fitted("geometric_error", "b.head.Rz", 1e-9, 3e-10)}));
  ASSERT_TRUE(d.is_identified);
  EXPECT_THAT(d.answers[0].places, testing::UnorderedElementsAre("b.end", "b.head.Rz"));
}

TEST(Decision, WhatMovesThePlatformAlikeInPrincipleIsOneAnswer) {
  const Decision d = decide(
      round_of({fitted("eccentricity", "q2", 0), fitted("gravity_compensator", "q2", -0.5, 1.2),
                fitted("payload", "platform", -30)}));
  ASSERT_TRUE(d.is_identified);
  EXPECT_EQ(d.answers[0].effect_class, "geometry, or weight");
  EXPECT_TRUE(d.answers[0].is_inseparable);
  EXPECT_THAT(d.answers[0].places, ElementsAre("q2"));
  // Whichever is the better.
  const Decision other = decide(
      round_of({fitted("gravity_compensator", "q2", 0), fitted("eccentricity", "q2", -0.5, 1.2)}));
  ASSERT_TRUE(other.is_identified);
  EXPECT_EQ(other.answers[0].effect_class, "weight, or geometry");
  // Behind the last joint, and in front of one.
  const Decision end = decide(round_of({fitted("target_lever_arm", "sensor", 0),
                                        fitted("geometric_error", "end", -0.2, 0.1),
                                        fitted("geometric_error", "fore", -0.4, 0.1)}));
  ASSERT_TRUE(end.is_identified);
  EXPECT_EQ(end.answers[0].effect_class, "geometry, or the instrument");
  EXPECT_THAT(end.answers[0].places, ElementsAre("sensor", "end", "fore"));
}

TEST(Decision, WhatReadingsDistinguishIsNotOneAnswer) {
  const auto narrowed = [](const std::string& at, double d_prime, const char* kind) {
    return decide(round_of({fitted("eccentricity", "q2", 0), fitted(kind, at, -0.5, d_prime)}))
        .is_narrowed_down;
  };
  EXPECT_TRUE(narrowed("q2", 3, "gravity_compensator"));
  EXPECT_TRUE(narrowed("q3", 1, "bearing_compliance"));
  EXPECT_TRUE(narrowed("q2", 1, "friction"));
}

TEST(Decision, NothingCompetesWithTheWeightOfAllKinds) {
  // 0.6 x against 0.6 ln n with n kinds: even at x = ln n.
  const double kinds = static_cast<double>(vjm::effect_kinds().size());
  EXPECT_EQ(DecisionRules{}.odds_of_nothing, kinds);
  const Decision even = decide(round_of({fitted("friction", "q1", std::log(kinds))}, 0));
  EXPECT_FALSE(even.is_identified);
  EXPECT_NEAR(even.nothing, 0.5, 1e-9);
  const Decision clear = decide(round_of({fitted("friction", "q1", 12)}, 0));
  EXPECT_TRUE(clear.is_identified);
}

// The weight of nothing is (38 e^0)^0.6, that of log 38 + x by e^0.6x of it.
TEST(Decision, NothingIsTheVerdictWhereItIsTheMostProbableAnswer) {
  const double even = std::log(static_cast<double>(vjm::effect_kinds().size()));
  struct Row {
    const char* what;
    std::vector<RankedCandidate> ranking;
    double nothing;  // its probability
    bool is_none_needed, is_narrowed_down;
  };
  const double less = std::exp(-0.6 * 0.1), more = std::exp(0.6 * 0.1);
  const std::vector<Row> rows{
      {"one that is less probable",
       {fitted("friction", "q1", even - 0.1)},
       1 / (1 + less),
       true,
       false},
      {"one that is more probable",
       {fitted("friction", "q1", even + 0.1)},
       1 / (1 + more),
       false,
       true},
      {"each is less probable, not all together",
       {fitted("friction", "q1", even - 0.1), fitted("creep", "q2", even - 0.1)},
       1 / (1 + 2 * less),
       true,
       false},
      {"laws of one answer add up",
       {fitted("clearance", "q1", even - 0.1), fitted("hardening", "q1", even - 0.1)},
       1 / (1 + 2 * less),
       false,
       true}};
  for (const Row& row : rows) {
    const Decision d = decide(round_of(row.ranking, 0));
    EXPECT_NEAR(d.nothing, row.nothing, 1e-9) << row.what;
    EXPECT_EQ(d.is_none_needed, row.is_none_needed) << row.what;
    EXPECT_EQ(d.is_narrowed_down, row.is_narrowed_down) << row.what;
    EXPECT_FALSE(d.is_identified) << row.what;
    EXPECT_FALSE(d.answers.empty()) << row.what;
  }
  // Nor where the smooth error, of no drive and no time, is what is most probable.
  DiagnosisStep step = round_of({fitted("friction", "q1", even - 5)}, 0);
  step.free_form.over = SmoothOver::other;
  step.free_form.log = even + 0.1;
  EXPECT_FALSE(decide(step).is_none_needed);
  step.free_form.log = even - 0.1;
  EXPECT_TRUE(decide(step).is_none_needed);
  EXPECT_FALSE(decide(step, {.lead_of_nothing = 2}).is_none_needed);
  // An answer that holds the level is one, whatever the lead.
  EXPECT_FALSE(decide(round_of({fitted("friction", "q1", 20)}, 0)).is_none_needed);
}

TEST(Decision, ADiscrepancyCountsForTheDriveWhoseLawItIs) {
  DiagnosisStep step = round_of({fitted("hardening", "q2", 0)});
  step.log_evidence_without = 0;
  step.free_form = {.log = 1, .depends_on = "the load of arm.q2", .drive = "arm.q2"};
  step.log_evidence_without = -1;
  const Decision of_drive = decide(step, {.odds_of_nothing = 1e-6});
  EXPECT_TRUE(of_drive.is_identified);
  EXPECT_NEAR(of_drive.unexplained, 0, 1e-12);
  step.free_form.drive.clear();
  const Decision other = decide(step, {.odds_of_nothing = 1e-6});
  EXPECT_FALSE(other.is_identified);
  EXPECT_NEAR(other.unexplained, 0.5, 1e-3);
}

TEST(Decision, ADiscrepancyOverTimeCountsForDrift) {
  DiagnosisStep step =
      round_of({fitted("friction", "q1", -9), fitted("session_drift", "sensor", -1)});
  step.log_evidence_without = -20;
  step.free_form = {
      .log = 19, .depends_on = "time in the cycle", .drive = "", .over = SmoothOver::time};
  const Decision drift = decide(step);
  ASSERT_TRUE(drift.is_identified);
  EXPECT_THAT(drift.answers[0].places, ElementsAre("sensor"));
  EXPECT_NEAR(drift.unexplained, 0, 1e-12);
  step.free_form.over = SmoothOver::temperature;
  EXPECT_GT(decide(step).unexplained, 0.4);
  // A drift that explains nothing lends its name to nothing.
  step.free_form.over = SmoothOver::time;
  step.log_evidence_without = -0.5;
  step.free_form.log = 0.5;
  EXPECT_GT(decide(step, {.odds_of_nothing = 1e-6}).unexplained, 0.4);
}

TEST(Decision, WhatImitatesTheBestCountsAsItDoes) {
  RankedCandidate imitator = fitted("friction", "q2", 0);
  imitator.fit.reset();
  imitator.falls_short = 0;
  const Decision same_class = decide(round_of({fitted("friction", "q1", 0), imitator}));
  ASSERT_TRUE(same_class.is_identified);
  EXPECT_THAT(same_class.answers[0].places, ElementsAre("q1", "q2"));
  imitator.candidate.effect.kind = vjm::effect_kind("creep");
  const Decision other_class = decide(round_of({fitted("friction", "q1", 0), imitator}));
  EXPECT_FALSE(other_class.is_identified);
  EXPECT_EQ(other_class.answers.size(), 2u);
}

TEST(Decision, WhatImitatesInPartCountsForLess) {
  RankedCandidate imitator = fitted("creep", "q2", 0);
  imitator.fit.reset();
  imitator.falls_short = 4;
  const double exponent = DecisionRules().exponent;
  const Decision d = decide(round_of({fitted("friction", "q1", 0), imitator}));
  ASSERT_EQ(d.answers.size(), 2u);
  EXPECT_NEAR(d.answers[1].probability / d.answers[0].probability, std::exp(-exponent * 2), 1e-9);
  imitator.falls_short = 40;
  EXPECT_TRUE(decide(round_of({fitted("friction", "q1", 0), imitator})).is_identified);
}

TEST(Decision, ALongListIsNone) {
  std::vector<RankedCandidate> ranking;
  for (const char* kind : {"friction", "creep", "eccentricity", "payload", "thermal_expansion",
                           "wrench_gain", "target_lever_arm"})
    ranking.push_back(fitted(kind, "q1", 0));
  const Decision d = decide(round_of(ranking));
  EXPECT_FALSE(d.is_identified);
  EXPECT_FALSE(d.is_narrowed_down);
}

// What explains nothing, and the order of what stands behind the best, change nothing.
TEST(Decision, DependsOnNeitherOrderNorIdleCandidates) {
  std::vector<RankedCandidate> ranking{fitted("clearance", "q1", 0), fitted("friction", "q1", -1),
                                       fitted("creep", "q2", -2, 1), fitted("hardening", "q1", -3)};
  const Decision before = decide(round_of(ranking));
  std::reverse(ranking.begin() + 1, ranking.end());
  ranking.push_back(fitted("payload", "platform", -60));
  const Decision after = decide(round_of(ranking));
  ASSERT_EQ(after.answers.size(), before.answers.size());
  for (std::size_t i = 0; i < before.answers.size(); ++i) {
    EXPECT_EQ(after.answers[i].effect_class, before.answers[i].effect_class);
    EXPECT_NEAR(after.answers[i].probability, before.answers[i].probability, 1e-12);
  }
}

TEST(Decision, WithoutFitsThereIsNone) { EXPECT_TRUE(decide(DiagnosisStep{}).answers.empty()); }

}  // namespace
}  // namespace kinetostat::calibration::decision_test
