// What stands against a confident name.
#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/diagnosis/found_effect.h"
#include "kinetostat/calibration/statistics/normal.h"
#include "kinetostat/common/error.h"

#include "calibration/laboratory.h"
#include "calibration/load_loops.h"

namespace kinetostat::calibration::verdict_test {
namespace {

using test::Laboratory;
using test::loops;
using testing::HasSubstr;

const std::string slide =
    "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  cell:\n"
    "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
    "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";

// With noise that is stated fifty times too small nothing explains the readings; friction that is
// really there is then not all that may be missing.
TEST(Verdict, NoNameWhereTheNoiseWouldHaveToBeManyTimesTheStatedOne) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  Campaign campaign = laboratory.measure(loops());
  const Diagnosis right = laboratory.diagnose(campaign, {"friction", "creep"});
  EXPECT_EQ(right.verdict, Verdict::identified);
  EXPECT_FALSE(right.or_something_else);
  for (Reading& reading : campaign.readings) reading.sigma /= 50;
  const Diagnosis wrong = laboratory.diagnose(campaign, {"friction", "creep"});
  EXPECT_NE(wrong.verdict, Verdict::identified);
  ASSERT_FALSE(wrong.found.empty());
  EXPECT_TRUE(wrong.or_something_else);
  EXPECT_THAT(laboratory.json(campaign, wrong).at("remarks").at(0).get<std::string>(),
              HasSubstr("times the stated noise"));
}

// What is kept back may say nothing of an effect: a cycle up alone nothing of presliding.
TEST(Verdict, ReadingsThatAreKeptBackNeedNotDetermineTheEffect) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=0 um");
  Campaign campaign = laboratory.measure(loops(4));
  for (Reading& reading : campaign.readings)
    if (reading.cycle == "2") reading.role = Role::confirm;
  const Diagnosis d = laboratory.diagnose(campaign, {"friction", "creep"});
  ASSERT_EQ(d.found.size(), 1);
  EXPECT_EQ(d.found[0].candidate.effect.kind->name, "friction");
  for (const WaterfallStage& stage : d.waterfall) {
    if (stage.name.rfind("+ ", 0) != 0) continue;
    EXPECT_TRUE(std::isfinite(stage.confirmed)) << stage.name;
  }
}

// The prior of an effect that is far larger than usual does not hold its size back. Usual is a
// spring that is twice as stiff where the readings deflect it most: 1.23e12 N/m^3.
TEST(Verdict, ASizeFarBeyondTheUsualIsFittedAsItIs) {
  for (const double size : {1e12, 3e13, 1e14}) {
    Laboratory laboratory(slide);
    laboratory.hide("hardening", "q", fmt::format("k3={} N/m^3", size));
    std::string plan = "id,cycle,step,time,fz\n";
    for (int n = 0; n < 76; ++n) {
      const int level = n % 38 < 19 ? n % 38 - 9 : 28 - n % 38;  // -900 N to 900 N and back
      plan += fmt::format("a{0},{1},{0},{2},{3}\n", n, n / 38, 60 * n, 100 * level);
    }
    const Diagnosis d = laboratory.diagnose(
        laboratory.measure(plan), {"hardening", "friction", "clearance", "piecewise_stiffness"});
    ASSERT_EQ(d.found.size(), 1) << size;
    EXPECT_EQ(d.found[0].candidate.effect.kind->name, "hardening");
    EXPECT_NEAR(d.found[0].candidate.effect.values[0], size, 4 * d.found[0].deviations[0]);
    EXPECT_LT(d.found[0].deviations[0], 0.2 * size);
  }
}

// A creep that the catalogue lacks is neither friction nor "friction and a drift": an error without
// a form is far likelier than friction, and what friction leaves of it is no drift.
TEST(Verdict, WhatAnErrorWithoutAFormExplainsBetterIsNoSecondEffect) {
  Laboratory laboratory(slide);
  laboratory.options().translation_noise = 5e-6;
  laboratory.hide("creep", "q", "c=3e-8 m/N,tau=400 s");
  std::string plan = "id,cycle,step,time,fz\n";
  int n = 0, time = 0;
  for (int cycle = 1; cycle <= 8; ++cycle)
    for (int k = 0; k < 25; ++k) {
      const int level = k <= 6 ? k : k <= 18 ? 12 - k : k - 24;  // up, down and reversed
      time += 30 + 7 * ++n % 11;
      plan += fmt::format("a{0},{1},{0},{2},{3}\n", n, cycle, time, 150 * level);
    }
  const Diagnosis d = laboratory.diagnose(laboratory.measure(plan), {"session_drift", "friction"});
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_EQ(d.found[0].candidate.name(), "friction at cell.q");
  EXPECT_LT(d.above_free_form, beaten_by_free_form);
}

// Nothing hidden, but noise that was stated too small: by little it is said, by much nothing is
// sure.
TEST(Verdict, AMisfitBeyondTheStatedNoiseIsNotNothing) {
  Laboratory laboratory(slide);
  const Campaign campaign = laboratory.measure(loops());
  const auto diagnosed = [&](double stated) {
    Campaign changed = campaign;
    for (Reading& reading : changed.readings) reading.sigma *= stated;
    return laboratory.diagnose(changed, {"friction", "creep"});
  };
  EXPECT_EQ(diagnosed(1).verdict, Verdict::none_needed);
  const Diagnosis little = diagnosed(0.6);
  EXPECT_EQ(little.verdict, Verdict::none_needed);
  EXPECT_THAT(report::text(laboratory.robot(), campaign, little),
              HasSubstr("times the stated noise"));
  const Diagnosis much = diagnosed(0.2);
  EXPECT_EQ(much.verdict, Verdict::unexplained);
  EXPECT_TRUE(much.found.empty());
  EXPECT_THAT(report::text(laboratory.robot(), campaign, much),
              HasSubstr("times the stated noise"));
}

// Larger than anybody has seen one, but it explains all that is read: why should it have no name?
TEST(Verdict, AnEffectOfUnusualSizeThatFitsHasItsName) {
  Laboratory laboratory(slide);
  laboratory.hide("creep", "q", "c=1.5e-6 m/N,tau=100 s");
  const Campaign campaign = laboratory.measure(loops());
  const Diagnosis d = laboratory.diagnose(campaign, {"clearance", "creep"});
  EXPECT_EQ(d.verdict, Verdict::identified);
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_GT(d.found[0].times_usual, unusual);
  EXPECT_THAT(report::text(laboratory.robot(), campaign, d),
              HasSubstr("15 times as large as such an effect usually is"));
}

// The more readings count from one noisy reading, the surer it was that "something" was left: an
// effect that explains all but that noise keeps its name.
TEST(Verdict, AnEffectOfUnusualSizeReadFromANoisyDatumHasItsName) {
  Laboratory laboratory(slide);
  laboratory.hide("creep", "q", "c=1.5e-6 m/N,tau=100 s");
  laboratory.options().translation_noise = 3e-4;
  Campaign campaign = laboratory.measure(loops(24));
  Normal normal(5);
  std::map<std::string, double> datum;
  for (Reading& reading : campaign.readings) {
    const auto [found, fresh] = datum.try_emplace(reading.cycle, 0);
    if (fresh) found->second = 1.5 * reading.sigma[2] * normal();
    reading.displacement[2] += found->second;
  }
  const Diagnosis d = laboratory.diagnose(campaign, {"clearance", "creep"});
  EXPECT_EQ(to_string(d.verdict), "identified");
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_GT(d.found[0].times_usual, unusual);
  EXPECT_LT(d.after->p_value, 1e-6);  // by independent noise much would be left
}

// A creep of fifteen times its usual size. An unmodelled smooth error has no size of its own: that
// is no evidence for it.
TEST(Verdict, AnUnusualSizeIsNoReasonForAnErrorWithoutAForm) {
  Laboratory laboratory(slide);
  laboratory.hide("creep", "q", "c=1.5e-6 m/N,tau=100 s");
  const Diagnosis d =
      laboratory.diagnose(laboratory.measure(loops()), {"session_drift", "creep", "friction"});
  EXPECT_EQ(d.verdict, Verdict::identified);
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_EQ(d.found[0].candidate.name(), "creep at cell.q");
  EXPECT_GT(d.found[0].times_usual, unusual);
  EXPECT_LT(d.steps[0].free_form_probability, 1e-3);
}

// A gap with softer corners than those of the catalogue. What is left of it looks like another law
// of the joint, and is none.
TEST(Verdict, WhatALawGetsWrongIsNoSecondEffect) {
  Laboratory laboratory(
      slide +
      "effect_kinds:\n  soft_gap: {force: '1e6 * (sqrt((d - g)^2 + (0.5 * g)^2) - "
      "sqrt((d + g)^2 + (0.5 * g)^2)) / 2', parameters: {g: {unit: mm, between: [0, 10], prior: "
      "0.1}}}\n");
  laboratory.hide("soft_gap", "q", "g=0.1 mm");
  const Campaign campaign = laboratory.measure(loops());
  const Diagnosis d =
      laboratory.diagnose(campaign, {"clearance", "piecewise_stiffness", "friction", "creep"});
  ASSERT_EQ(d.found.size(), 1u);
  EXPECT_EQ(d.found[0].candidate.name(), "clearance at cell.q");
  EXPECT_LT(d.rest_p_value, 0.01);
  EXPECT_EQ(d.rest_of_laws, "piecewise_stiffness at cell.q");
  EXPECT_FALSE(d.or_something_else);
  EXPECT_THAT(report::text(laboratory.robot(), campaign, d),
              HasSubstr("no larger than the error of an idealised law may be"));
}

// Beside one effect another one of a thirtieth of its size may be its law; one of a seventh is
// another.
TEST(Verdict, ASecondEffectIsMoreThanALawMayGetWrong) {
  const auto diagnosed = [](const std::string& drift) {
    Laboratory laboratory(slide);
    laboratory.hide("friction", "q", "force=300 N,presliding=3 um");
    laboratory.hide("session_drift", "sensor", drift);
    return laboratory.diagnose(laboratory.measure(loops()), {"friction", "session_drift"});
  };
  const Diagnosis small = diagnosed("z=0.01 um/s"), large = diagnosed("z=0.04 um/s");
  ASSERT_EQ(small.found.size(), 1u);
  EXPECT_EQ(small.found[0].candidate.name(), "friction at cell.q");
  EXPECT_EQ(small.rest_of_laws, "session_drift at sensor");
  ASSERT_EQ(large.found.size(), 2u);
  EXPECT_EQ(large.rest_of_laws, "");
}

// The law of a balancer goes round with its phase and has minima on all sides; a wrong one would
// leave the name to an error of the gear, which is nearly a sine of the angle as well.
TEST(Verdict, ABalancerIsFoundWhateverItsPhase) {
  for (const int phase : {-150, -80, 10, 100}) {
    Laboratory laboratory(
        "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
        "gravity: {direction: [0, 0, -1]}\nchain_types:\n  arm:\n"
        "    - actuator: {name: q1, axis: Ry, stiffness: 1.0e6 N m/rad}\n"
        "    - tool: [0, 0, 1000]\nmanipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n");
    laboratory.hide("gravity_compensator", "q1",
                    fmt::format("stiffness=20 N/mm,arm=250 mm,distance=650 mm,free_length=500 mm,"
                                "angle={} deg",
                                phase));
    laboratory.options().displacement = DisplacementKind::absolute;
    laboratory.options().translation_noise = 1e-5;
    laboratory.options().components = {true, false, true, false, false, false};
    std::string plan = "id,q1,fx\n";
    for (int i = 0; i < 30; ++i)
      plan += fmt::format("p{},{},{}\n", i, -120 + 8 * i, 400 * (i % 3 - 1));
    const Diagnosis d = laboratory.diagnose(laboratory.measure(plan),
                                            {"gravity_compensator", "eccentricity", "payload"});
    ASSERT_FALSE(d.found.empty()) << phase;
    EXPECT_EQ(d.found[0].candidate.name(), "gravity_compensator at arm.q1") << phase;
    EXPECT_LT(d.after->reduced(), 1.3) << phase;
  }
}

// A joint that was assembled askew stands as one that is pushed: the one number of the push is no
// evidence against the six of the frame. Both are laws of one class at one place.
TEST(Verdict, ACandidateThatFitsAsWellStaysWhateverItsPrior) {
  Laboratory laboratory(
      "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  arm:\n"
      "    - actuator: {name: q1, axis: Rz, stiffness: 4.0e4 N m/rad}\n    - tool: [400, 0, 0]\n"
      "    - actuator: {name: q2, axis: Rz, home: 40, stiffness: 2.0e4 N m/rad}\n"
      "    - tool: [300, 0, 0]\nmanipulator: {chain: arm}\n");
  laboratory.hide("geometric_error", "q2", "rz=0.2 deg");
  laboratory.options().displacement = DisplacementKind::absolute;
  laboratory.options().translation_noise = 1e-5;
  laboratory.options().components = {true, true, false, false, false, false};
  std::string plan = "id,q1,q2,fx\n";
  for (int i = 0; i < 24; ++i)
    plan += fmt::format("p{},{},{},{}\n", i, 15 * (i % 6), 10 + 30 * (i / 6), 40 * (i % 3));
  const Diagnosis d = laboratory.diagnose(laboratory.measure(plan), {"preload", "geometric_error"});
  EXPECT_EQ(d.verdict, Verdict::identified);
  ASSERT_EQ(d.found.size(), 1u);
  ASSERT_EQ(d.found[0].decision.answers.size(), 1u);
  const Answer& answer = d.found[0].decision.answers[0];
  EXPECT_EQ(answer.effect_class, "geometry, or a preloaded spring");
  EXPECT_THAT(answer.places, testing::Contains("arm.q2"));
  for (const char* law : {"preload", "geometric_error"})
    EXPECT_TRUE(std::any_of(answer.laws.begin(), answer.laws.end(), [&](const LawShare& share) {
      return share.effect == law && share.share > 0.01;
    })) << law;
}

// A lag of one reading is no creep: it would be a name for every hysteresis.
TEST(Verdict, CreepIsNotFasterThanTheReadings) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  const Campaign campaign = laboratory.measure(loops());
  const Diagnosis alone = laboratory.diagnose(campaign, {"creep"});
  const RankedCandidate& creep = alone.steps.at(0).ranking.at(0);
  ASSERT_TRUE(creep.fit);
  EXPECT_GE(creep.fit->values[1], 30);  // tau [s]
  const Diagnosis both = laboratory.diagnose(campaign, {"creep", "friction"});
  EXPECT_EQ(both.steps.at(0).ranking.at(0).candidate.effect.kind->name, "friction");
}

// The larger an effect would have to be, the more it has to explain.
TEST(Verdict, AnAbsurdSizeMustExplainMore) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  DiagnosisStep step = laboratory.diagnose(laboratory.measure(loops()), {"friction"}).steps.at(0);
  RankedCandidate& best = step.ranking.at(0);
  step.free_form.log = -1e6;  // no smooth error does better
  const auto with = [&](double times, double left) {
    best.fit->values[0] = times * best.candidate.deviations[0];
    step.share_left = left;
    return is_absurd(step);
  };
  EXPECT_FALSE(with(5, 0.9));  // that is no unusual size
  EXPECT_FALSE(with(10, 0.2));
  EXPECT_TRUE(with(10, 0.4));
  EXPECT_FALSE(with(100, 0.01));
  EXPECT_TRUE(with(100, 0.1));
  EXPECT_TRUE(with(3000, 0.01));
}

// Readings in other units are no effect, and in differences no kinematics.
TEST(Verdict, OtherUnitsAreNoEffect) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  Campaign campaign = laboratory.measure(loops());
  const Diagnosis right = laboratory.diagnose(campaign, {});
  EXPECT_EQ(right.unit_error, "");
  EXPECT_EQ(right.verdict, Verdict::identified);
  for (Reading& reading : campaign.readings) reading.displacement *= 1000;
  try {
    const Diagnosis wrong = laboratory.diagnose(campaign, {});
    EXPECT_EQ(wrong.verdict, Verdict::unexplained);
    EXPECT_FALSE(wrong.by_kinematics);
    EXPECT_THAT(wrong.unit_error, HasSubstr("times the predicted ones"));
  } catch (const common::NotIdentifiable& error) {
    EXPECT_THAT(error.what(), HasSubstr("times the predicted ones"));
  }
}

// A cycle that is off as a whole scatters beside others; that is no larger noise.
TEST(Verdict, ScatterThatWasExplainedIsNoNoise) {
  Laboratory laboratory(slide);
  laboratory.hide("cycle_offset", "sensor", "z=200 um,cycle=2");
  laboratory.options().translation_noise = 5e-6;
  const Campaign campaign = laboratory.measure(loops(5));
  const Diagnosis d = laboratory.diagnose(campaign, {"cycle_offset", "session_drift"});
  ASSERT_EQ(d.verdict, Verdict::identified);
  EXPECT_EQ(d.found.at(0).candidate.effect.kind->name, "cycle_offset");
  ASSERT_TRUE(d.noise_check);
  EXPECT_LT(d.noise_check->p_value, 1e-3);
  for (const auto& remark : laboratory.json(campaign, d).at("remarks"))
    EXPECT_THAT(remark.get<std::string>(), testing::Not(HasSubstr("state that noise")));
}

// Who is not fitted because others leave noise alone would have been far behind them.
TEST(Verdict, WhoIsHopelessIsSo) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  const Campaign campaign = laboratory.measure(loops());
  const Diagnosis d = laboratory.diagnose(campaign, {});
  const DiagnosisStep& step = d.steps.at(0);
  ASSERT_TRUE(step.ranking.at(0).fit);
  int hopeless = 0;
  for (const RankedCandidate& ranked : step.ranking) {
    if (!ranked.is_hopeless) continue;
    ++hopeless;
    EXPECT_FALSE(ranked.fit);
    const Diagnosis own = laboratory.diagnose(campaign, {ranked.candidate.effect.kind->name});
    const auto& of_kind = own.steps.at(0).ranking;
    const auto same = std::find_if(of_kind.begin(), of_kind.end(), [&](const auto& other) {
      return other.candidate.name() == ranked.candidate.name();
    });
    ASSERT_NE(same, of_kind.end());
    if (!same->fit) continue;  // its fits have failed
    const double behind = (same->fit->squared_error - step.ranking[0].fit->squared_error) / 2;
    EXPECT_GT(learning_rate * behind, std::log(1e12)) << ranked.candidate.name();
  }
  EXPECT_GT(hopeless, 3);
}

// A formula of the robot file without a parameter has nothing that readings could tell.
TEST(Verdict, EffectsWithoutParametersAreNotTried) {
  Laboratory laboratory(slide + "effect_kinds:\n  stop: {force: '2 * d'}\n");
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  for (const Candidate& candidate : candidates(laboratory.robot(), {}))
    EXPECT_NE(candidate.effect.kind->name, "stop");
  const Diagnosis d = laboratory.diagnose(laboratory.measure(loops()), {"stop", "friction"});
  EXPECT_EQ(d.steps.at(0).ranking.at(0).candidate.effect.kind->name, "friction");
  EXPECT_THROW(laboratory.hide("stop", "q", "3"), std::invalid_argument);
}

// A balancer is sought about joints that turn: here nothing is left to try.
TEST(Verdict, NothingToTryIsNoCrash) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  const Diagnosis d = laboratory.diagnose(laboratory.measure(loops()), {"gravity_compensator"});
  EXPECT_TRUE(d.steps.at(0).ranking.empty());
  EXPECT_TRUE(d.found.empty());
  EXPECT_EQ(d.verdict, Verdict::unexplained);
}

// Nanoseconds that are taken for seconds: no creep that an effect may have is slow enough.
TEST(Verdict, ReadingsThatAreYearsApartShowNoCreep) {
  Laboratory laboratory(slide);
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  Campaign campaign = laboratory.measure(loops());
  for (Reading& reading : campaign.readings) reading.time = 1e9 * *reading.time;
  const Diagnosis d = laboratory.diagnose(campaign, {"creep", "friction"});
  EXPECT_EQ(d.steps.at(0).ranking.at(0).candidate.effect.kind->name, "friction");
}

const std::string hanging_slide =
    "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\n"
    "gravity: {direction: [0, 0, -1]}\n"
    "links: {hook: {rigid: [0, 0, 10], mass: {mass: 40 kg, center: [0, 0, 0]}}}\n"
    "chain_types:\n  cell:\n"
    "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n    - link: hook\n"
    "manipulator: {chain: cell}\nuncertain:\n  - {stiffness: q}\n";

// Weight that is put on against friction, or that has settled: either is found as what it was.
TEST(Verdict, FrictionIsNamedHoweverItsCyclesStart) {
  for (const int settled : {0, 1}) {
    Laboratory laboratory(hanging_slide);
    laboratory.hide("friction", "q", fmt::format("force=60 N,presliding=3 um,settled={}", settled));
    const Diagnosis d = laboratory.diagnose(laboratory.measure(loops()), {"friction", "creep"});
    EXPECT_EQ(d.verdict, Verdict::identified) << settled;
    ASSERT_FALSE(d.found.empty());
    EXPECT_EQ(d.found[0].candidate.name(), "friction at cell.q");
    EXPECT_EQ(d.found[0].candidate.effect.values[2], settled);
  }
}

// The same of what creeps under its weight.
TEST(Verdict, CreepIsNamedHoweverItsCyclesStart) {
  for (const int settled : {0, 1}) {
    Laboratory laboratory(hanging_slide);
    laboratory.hide("creep", "q", fmt::format("c=2e-7 m/N,tau=120 s,settled={}", settled));
    const Diagnosis d =
        laboratory.diagnose(laboratory.measure(loops()), {"friction", "creep", "session_drift"});
    EXPECT_EQ(d.verdict, Verdict::identified) << settled;
    ASSERT_FALSE(d.found.empty());
    EXPECT_EQ(d.found[0].candidate.name(), "creep at cell.q");
    EXPECT_EQ(d.found[0].candidate.effect.values[2], settled);
  }
}

// A spring that no load reaches, and one that yields in proportion to another, stay at their
// nominal values and are named; the verdict is that of the rest.
TEST(Verdict, WhatTheReadingsDoNotDetermineStaysNominal) {
  Laboratory laboratory(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  "
      "cell:\n"
      "    - actuator: {name: p, axis: Tx, stiffness: 1000}\n"
      "    - actuator: {name: r, axis: Tz, stiffness: 2000}\n"
      "    - actuator: {name: q, axis: Tz, stiffness: 1000}\n"
      "manipulator: {chain: cell}\n"
      "uncertain:\n  - {stiffness: p}\n  - {stiffness: r}\n  - {stiffness: q}\n");
  laboratory.hide("friction", "q", "force=60 N,presliding=3 um");
  const Diagnosis d = laboratory.diagnose(laboratory.measure(loops()), {"friction", "creep"});
  ASSERT_FALSE(d.found.empty());
  EXPECT_EQ(d.verdict, Verdict::identified);  // r and q stand in one line: one answer
  EXPECT_THAT(d.found[0].decision.answers[0].places,
              testing::UnorderedElementsAre("cell.r", "cell.q"));
  EXPECT_EQ(d.found[0].candidate.effect.kind->name, "friction");
  ASSERT_GE(d.weak.size(), 2u);
  EXPECT_EQ(d.weak[0],
            "the stiffness of 'p' stays at its nominal value: no reading depends on it.");
  EXPECT_EQ(d.weak[1],
            "the stiffness of 'q' stays at its nominal value: it is confounded with the fitted "
            "parameters.");
}

// A drift against the load, by more than the spring yields: without it the spring would be rigid.
TEST(Verdict, WhatDrivesAStiffnessToInfinityIsFound) {
  Laboratory laboratory(slide);
  laboratory.hide("session_drift", "sensor", "z=-0.03 um/s");
  std::string plan = "id,cycle,step,time,fz\n";
  for (int n = 0, time = 0; n < 36; ++n, time += 60)
    plan += fmt::format("a{0},{1},{0},{2},{3}\n", n, 1 + n / 6, time,
                        std::vector{0, 2, 4, 6, 6, 2}.at(static_cast<std::size_t>(n % 6)));
  const Campaign campaign = laboratory.measure(plan);
  const Diagnosis d = laboratory.diagnose(campaign, {"session_drift", "creep", "clearance"});
  ASSERT_EQ(d.verdict, Verdict::identified);
  EXPECT_EQ(d.found[0].candidate.name(), "session_drift at sensor");
  EXPECT_THAT(d.weak.at(0), HasSubstr("far from its design"));
}

// A sign error does so as well, and no effect is sought in the rest.
TEST(Verdict, ASignErrorIsNoMissingEffect) {
  Laboratory laboratory(slide);
  Campaign campaign = laboratory.measure(loops());
  for (Reading& reading : campaign.readings) reading.displacement *= -1;
  EXPECT_THROW((void)laboratory.diagnose(campaign, {"friction", "creep"}), common::NotIdentifiable);
}

// Quiet readings without load say little about those under load, which nobody repeated.
TEST(Verdict, NoiseWithoutLoadRefutesNothingUnderLoad) {
  for (const bool repeated : {false, true}) {
    Laboratory laboratory(slide);
    std::string plan = "id,cycle,step,time,fz\n";
    for (int n = 0; n < 60; ++n) {
      const int load =
          n % 3 == 0 ? 0 : (n % 2 == 0 ? 10 : -10) * (30 + (repeated ? 15 * (n % 5) : n));
      plan += fmt::format("a{0},{1},{0},{2},{3}\n", n, n / 3, 30 * n, load);
    }
    Campaign campaign = laboratory.measure(plan);
    campaign.noise_stated = false;
    Normal normal(5);
    for (Reading& reading : campaign.readings)
      if (!reading.load.force.isZero(0)) reading.displacement[2] += 5e-6 * normal();
    const Diagnosis d = laboratory.diagnose(campaign, {"friction", "hardening", "clearance"});
    if (repeated) {
      EXPECT_EQ(d.verdict, Verdict::none_needed);
      EXPECT_FALSE(d.noise_without_load);
      continue;
    }
    EXPECT_EQ(d.verdict, Verdict::inconclusive);
    ASSERT_FALSE(d.missing.empty());
    EXPECT_THAT(d.missing[0], HasSubstr("only readings without load are repeated"));
    common::Progress silent;
    EXPECT_THAT(compare(laboratory.robot(), campaign, 1, silent).notes,
                testing::Contains(HasSubstr("Only readings without load are repeated")));
  }
}

// Nobody hangs a balancer on a joint that no drive moves; other laws may act there.
TEST(Verdict, BalancersAreSoughtAtDrives) {
  Laboratory laboratory(
      "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  arm:\n"
      "    - actuator: {name: q1, axis: Ry, stiffness: 4.0e4 N m/rad}\n    - tool: [0, 0, 400]\n"
      "    - passive: {name: q2, axis: Ry, home: 30, stiffness: 2.0e4 N m/rad}\n"
      "    - tool: [0, 0, 300]\nmanipulator: {chain: arm}\n");
  std::vector<std::string> names;
  for (const Candidate& c : candidates(laboratory.robot(), {"gravity_compensator", "preload"}))
    names.push_back(c.name());
  EXPECT_THAT(names, testing::Contains("gravity_compensator at arm.q1"));
  EXPECT_THAT(names, testing::Not(testing::Contains("gravity_compensator at arm.q2")));
  EXPECT_THAT(names, testing::Contains("preload at arm.q2"));
}

// A drive about a vertical axis lifts nothing, and neither do those behind it about parallel axes;
// one that tilts allows it for those behind it. Where gravity is not known any may lift.
TEST(Verdict, BalancersAreSoughtWhereWeightActs) {
  const auto balanced = [](const std::string& gravity, const std::string& second) {
    Laboratory laboratory(
        "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n" + gravity +
        "chain_types:\n  arm:\n" +
        "    - actuator: {name: q1, axis: Rz, stiffness: 4.0e4 N m/rad}\n"
        "    - tool: [400, 0, 0]\n"
        "    - actuator: {name: q2, axis: " +
        second + ", home: 30, stiffness: 2.0e4 N m/rad}\n" +
        "    - tool: [300, 0, 0]\n"
        "    - actuator: {name: q3, axis: Rz, home: 10, stiffness: 2.0e4 N m/rad}\n"
        "    - tool: [200, 0, 0]\nmanipulator: {chain: arm}\n");
    std::vector<std::string> at;
    for (const Candidate& c : candidates(laboratory.robot(), {"gravity_compensator"}))
      at.push_back(c.effect.at);
    return at;
  };
  const std::string down = "gravity: {direction: [0, 0, -1]}\n";
  EXPECT_THAT(balanced(down, "Rz"), testing::IsEmpty());
  EXPECT_THAT(balanced(down, "Ry"), testing::ElementsAre("arm.q2", "arm.q3"));
  EXPECT_THAT(balanced("", "Rz"), testing::ElementsAre("arm.q1", "arm.q2", "arm.q3"));
}

// Nobody balances a wrist: behind the first two axes that lift, the third of an arm with a
// turntable included, the five values of a balancer are a confounder of an eccentric drive.
TEST(Verdict, BalancersAreSoughtAtTheFirstAxesThatLift) {
  const auto balanced = [](const std::string& gravity) {
    std::string arm = "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n" +
                      gravity + "chain_types:\n  arm:\n";
    for (const char* joint : {"turntable, axis: Rz", "shoulder, axis: Ry", "elbow, axis: Ry",
                              "roll, axis: Rx", "wrist, axis: Ry"})
      arm += std::string("    - actuator: {name: ") + joint +
             ", home: 10, stiffness: 4.0e4 N m/rad}\n    - tool: [300, 0, 0]\n";
    Laboratory laboratory(arm + "manipulator: {chain: arm}\n");
    std::vector<std::string> at;
    for (const Candidate& c : candidates(laboratory.robot(), {"gravity_compensator"}))
      at.push_back(c.effect.at);
    return at;
  };
  EXPECT_THAT(balanced("gravity: {direction: [0, 0, -1]}\n"),
              testing::ElementsAre("arm.shoulder", "arm.elbow"));
  EXPECT_THAT(balanced(""), testing::ElementsAre("arm.turntable", "arm.shoulder", "arm.elbow"));
}

// Three sine waves of unlike lengths, none of them like the time.
double humidity(std::size_t reading) {
  const auto n = static_cast<double>(reading);
  return 50 + 10 * std::sin(0.45 * n + 1) + 3 * std::sin(1.7 * n) + 2 * std::sin(2.9 * n + 2);
}

// What changes with a further column of the table lasts from one reading to the next, as noise may.
TEST(Verdict, NamesTheColumnOnWhichAnErrorDepends) {
  for (const bool in_words : {false, true})
    for (const double size : {0.0, 1e-6}) {
      Laboratory laboratory(slide);
      Campaign campaign = laboratory.measure(loops(8));
      Covariate column{.name = "air", .values = {}};
      for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
        const double number = humidity(i);
        const bool is_damp = number > 50;
        column.values.push_back(in_words ? (is_damp ? "damp" : "dry") : fmt::format("{}", number));
        const double change = in_words ? (is_damp ? 1.0 : -1.0) : (number - 50) / 8;
        campaign.readings[i].displacement.array() += size * change;
      }
      campaign.covariates.push_back(column);
      const Diagnosis d = laboratory.diagnose(campaign, {"friction", "creep"});
      if (size == 0) {
        EXPECT_EQ(d.verdict, Verdict::none_needed);
      } else {
        EXPECT_EQ(d.verdict, Verdict::unexplained);
        EXPECT_THAT(d.left.depends_on, testing::StartsWith("the column 'air'"));
      }
    }
}

// The error that a lab has computed from its readings explains their noise, and says nothing new.
TEST(Verdict, TakesNoColumnThatIsComputedFromTheReadings) {
  Laboratory laboratory(slide);
  Campaign campaign = laboratory.measure(loops(8));
  Covariate error{.name = "error", .values = {}};
  for (const Reading& reading : campaign.readings)
    error.values.push_back(
        fmt::format("{}", reading.displacement[2] - reading.load.force[2] / 1e6));
  campaign.covariates = {error};
  const Diagnosis d = laboratory.diagnose(campaign, {"friction", "clearance", "creep"});
  EXPECT_EQ(d.verdict, Verdict::none_needed) << d.left.depends_on;
}

// A mass weighs nothing where the robot file does not say which way is down.
TEST(Verdict, SaysThatGravityIsMissing) {
  Laboratory laboratory(
      "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  arm:\n"
      "    - actuator: {name: q1, axis: Ry, stiffness: 4.0e4 N m/rad}\n    - tool: [0, 0, 400]\n"
      "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n");
  const Campaign campaign =
      laboratory.measure("id,q1,fz\na,90,20\nb,90,-20\nc,60,40\nd,60,-40\ne,30,20\nf,30,-20\n");
  const Diagnosis d = laboratory.diagnose(campaign, {"payload", "clearance"});
  const auto& ranking = d.steps.at(0).ranking;
  const auto payload = std::find_if(ranking.begin(), ranking.end(), [](const RankedCandidate& r) {
    return r.candidate.effect.kind->name == "payload";
  });
  ASSERT_NE(payload, ranking.end());
  EXPECT_THAT(payload->unobservable, testing::HasSubstr("the robot file states no 'gravity'"));
}

// Weight cancels in differences, and a gain of the load cell is what a stiffness takes up: both are
// said, though no effect is needed.
TEST(Verdict, SaysWhatItCouldNotSee) {
  Laboratory laboratory(
      "kinetostat: 1\nname: arm\nunits: {length: mm, force: N, angle: deg}\n"
      "gravity: {direction: [0, 0, -1]}\nchain_types:\n  arm:\n"
      "    - actuator: {name: q1, axis: Ry, stiffness: 4.0e4 N m/rad}\n    - tool: [0, 0, 400]\n"
      "manipulator: {chain: arm}\nuncertain:\n  - {stiffness: q1}\n");
  laboratory.options().translation_noise = 5e-6;
  const Campaign campaign = laboratory.measure(
      "id,q1,fz\na,90,20\nb,90,-20\nc,90,40\nd,90,-40\ne,88,20\nf,88,-20\ng,88,40\nh,88,-40\n");
  const Diagnosis d = laboratory.diagnose(campaign, {"payload", "wrench_gain", "clearance"});
  ASSERT_EQ(d.verdict, Verdict::none_needed);
  const std::vector<UnseenKind> unseen = unseen_kinds(d);
  ASSERT_EQ(unseen.size(), 2u);
  EXPECT_EQ(unseen[0].name, "payload");
  EXPECT_FALSE(unseen[0].confounded_with_fit);
  EXPECT_EQ(unseen[1].name, "wrench_gain");
  EXPECT_TRUE(unseen[1].confounded_with_fit);
  const std::string text = report::text(laboratory.robot(), campaign, d);
  EXPECT_THAT(
      text, testing::HasSubstr("Not observable in these readings at their usual sizes: payload."));
  EXPECT_THAT(text, testing::HasSubstr("Confounded with fitted parameters: wrench_gain."));
}

}  // namespace
}  // namespace kinetostat::calibration::verdict_test
