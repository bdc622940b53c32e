// What holds for every kind of effect.
#include "vjm/effect_catalogue.h"

#include <set>

#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"

#include "support/random.h"

namespace kinetostat::vjm::effect_catalogue_test {
namespace {

using kinetostat::test::Random;
using spatial::Vector6;
using test::Bench;

struct Step {
  Load load;
  Conditions conditions = {};
};

// A load path: time goes on, the temperature wanders, the load does as it likes.
std::vector<Step> random_path(const Bench& bench, Random& random, int length) {
  std::vector<Step> path;
  const auto temperatures = std::make_shared<std::vector<TemperatureAt>>();
  double time = 0;
  for (int k = 0; k < length; ++k) {
    const double elapsed = k == 0 ? 0 : random.uniform(20, 200);
    time += elapsed;
    Step step{.load = {.force = random.vector(bench.force),
                       .moment = random.vector(bench.moment),
                       .point_on_platform = random.vector(0.05),
                       .cell = spatial::rotation_from_rpy({0.3, -0.7, 2})}};
    step.conditions.time = time + 30;
    step.conditions.time_in_cycle = time;
    step.conditions.elapsed = elapsed;
    step.conditions.unloaded = k == 0;
    step.conditions.temperature = random.uniform(15, 35);
    temperatures->push_back({step.conditions.time, *step.conditions.temperature});
    step.conditions.past = {temperatures, temperatures->size()};
    path.push_back(step);
  }
  return path;
}

std::vector<ModelParameter> all_values(const std::vector<Effect>& effects) {
  std::vector<ModelParameter> parameters;
  for (std::size_t e = 0; e < effects.size(); ++e)
    for (Eigen::Index v = 0; v < effects[e].values.size(); ++v) parameters.push_back({{}, e, v});
  return parameters;
}

constexpr EquilibriumOptions tight{.tolerance = 1e-15};

// All responses along a path.
std::vector<Response> follow(const EffectModel& model, const Posture& posture,
                             const std::vector<Step>& path,
                             const std::vector<ModelParameter>& parameters) {
  std::vector<Response> all;
  Response before = model.at_rest(parameters.size());
  for (const Step& step : path) {
    all.push_back(model.respond(posture, step.load, step.conditions, before, parameters,
                                !parameters.empty()));
    EXPECT_TRUE(all.back().failure.empty()) << all.back().failure;
    before = all.back();
  }
  return all;
}

// Central differences of fourth order of all poses along a path, by one value of one effect.
std::vector<Vector6> numerical(const Bench& bench, const std::vector<Effect>& effects,
                               const ModelParameter& parameter, double h,
                               const std::vector<Step>& path) {
  const auto poses = [&](double steps) {
    std::vector<Effect> shifted = effects;
    shifted[parameter.effect].values[parameter.value] += steps * h;
    return follow(EffectModel(bench.manipulator, shifted, tight), bench.posture, path, {});
  };
  const auto a = poses(-2), b = poses(-1), c = poses(1), d = poses(2);
  std::vector<Vector6> result;
  for (std::size_t k = 0; k < path.size(); ++k)
    result.push_back((8 * spatial::pose_difference(b[k].observed, c[k].observed) -
                      spatial::pose_difference(a[k].observed, d[k].observed)) /
                     (12 * h));
  return result;
}

// A pose is known to about this [m, rad]: rounding of the solution and of the target.
constexpr double rounding = 3e-15;

// Short beside the rounded corners of a law, and beside a period of a harmonic.
double step_for(const Effect& effect, Eigen::Index value) {
  const bool is_order = effect.kind->parameters[static_cast<std::size_t>(value)].name == "order";
  return (is_order ? 2e-5 : 3e-4) * std::abs(effect.values[value]);
}

void expect_exact(const Bench& bench, const std::vector<Effect>& effects, int paths, int length) {
  const std::vector<ModelParameter> parameters = all_values(effects);
  Random random(11);
  for (int path_number = 0; path_number < paths; ++path_number) {
    const std::vector<Step> path = random_path(bench, random, length);
    const EffectModel model(bench.manipulator, effects, tight);
    const std::vector<Response> exact = follow(model, bench.posture, path, parameters);
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const auto& [springs, e, v] = parameters[p];
      if (effects[e].values[v] == 0) continue;  // not given: the axial value of a joint that slides
      if (effects[e].kind->parameters[static_cast<std::size_t>(v)].name == "drives_back") continue;
      const double h = step_for(effects[e], v);
      const std::vector<Vector6> differences = numerical(bench, effects, parameters[p], h, path);
      for (std::size_t k = 0; k < path.size(); ++k) {
        const Vector6 column = exact[k].derivatives.col(static_cast<Eigen::Index>(p));
        EXPECT_LT((differences[k] - column).norm(), 1e-6 * column.norm() + rounding / h)
            << bench.name << ": " << effects[e].name_of(v) << ", path " << path_number << " step "
            << k << "\nexact " << column.transpose() << "\ndifferences "
            << differences[k].transpose();
      }
    }
  }
}

// The arm again, with effects at places of another sort than in the catalogue: a rigid link, a mass
// that stands alone, the end of a chain that is not the origin of its body.
Bench other_places() {
  Bench bench = test::arm_bench();
  bench.effects = {test::effect(bench.manipulator, "self_weight", "arm.elbow", {12}),
                   test::effect(bench.manipulator, "self_weight", "arm.payload", {12}),
                   test::effect(bench.manipulator, "geometric_error", "rod.end",
                                {1e-3, -2e-3, 1e-3, 2e-3, -1e-3, 2e-3}),
                   test::effect(bench.manipulator, "geometric_error", "arm.end",
                                {1e-3, -2e-3, 1e-3, 2e-3, -1e-3, 2e-3})};
  return bench;
}

// The arm where the drive that moves the joint behind it, too, is away from home.
Bench turned_arm() {
  Bench bench = test::arm_bench();
  bench.posture = posture_from_joints(bench.manipulator, {{"q3", -0.5}}).posture;
  bench.effects = {test::effect(bench.manipulator, "transmission_ratio", "arm.q3", {2e-4}),
                   test::effect(bench.manipulator, "joint_offset", "arm.q4", {4e-3}),
                   test::effect(bench.manipulator, "joint_coupling", "arm.q4", {3e-4, 1}),
                   test::effect(bench.manipulator, "joint_coupling", "arm.q5", {3e-4, 2}),
                   test::effect(bench.manipulator, "stiffness_along_joint", "arm.q3", {0.4})};
  return bench;
}

// What several chains share.
Bench shared_mounts() {
  Bench bench = test::parallel_bench();
  const auto make = [&bench](const char* kind, const char* at, std::vector<double> values) {
    return test::effect(bench.manipulator, kind, at, std::move(values));
  };
  bench.effects = {make("base_compliance", "foundation", {1e-8, 3e-7}),
                   make("base_tilt", "foundation", {3e-7, 1e-7, 2e-7}),
                   make("platform_compliance", "tool", {2e-8, 1e-6}),
                   make("platform_compliance", "end", {2e-8, 1e-6}),
                   make("clearance", "z.rho", {2e-6, 0}),
                   make("friction", "x.rho", {40, 3e-7, 0, 0})};
  return bench;
}

const Bench& bench_number(int number) {
  static const Bench benches[] = {test::parallel_bench(), test::arm_bench(), other_places(),
                                  turned_arm(), shared_mounts()};
  return benches[number];
}

class EveryEffect : public testing::TestWithParam<std::pair<int, std::size_t>> {
 protected:
  const Bench& bench() const { return bench_number(GetParam().first); }
  const Effect& effect() const { return bench().effects[GetParam().second]; }
};

// But for what an instrument does to one reading after another: instrument_lag_test.cpp.
std::vector<std::pair<int, std::size_t>> every_effect() {
  std::vector<std::pair<int, std::size_t>> all;
  for (const int bench : {0, 1, 2, 3, 4})
    for (std::size_t e = 0; e < bench_number(bench).effects.size(); ++e)
      if (!bench_number(bench).effects[e].kind->acts_on_numbers()) all.emplace_back(bench, e);
  return all;
}

std::string name_of(const testing::TestParamInfo<std::pair<int, std::size_t>>& info) {
  static constexpr const char* names[] = {"_parallel_", "_arm_", "_elsewhere_", "_turned_",
                                          "_shared_"};
  return bench_number(info.param.first).effects[info.param.second].kind->name +
         names[info.param.first] + std::to_string(info.param.second);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(every_effect()), name_of);

// 50 states on each of two robots; with a history, ten paths of five.
TEST_P(EveryEffect, HasExactDerivatives) {
  const bool history = effect().kind->history > 0;
  expect_exact(bench(), {effect()}, history ? 10 : 50, history ? 5 : 1);
}

TEST(EffectDerivatives, AreExactWhereFrictionHasSettled) {
  const Bench bench = test::arm_bench();
  Effect friction;
  for (const Effect& effect : bench.effects)
    if (effect.kind->name == "friction") friction = effect;
  friction.values[2] = 1;
  expect_exact(bench, {friction}, 10, 5);
}

TEST(EffectDerivatives, AreExactWhereWeightHasCrept) {
  const Bench bench = test::arm_bench();
  Effect creep = test::effect(bench.manipulator, "creep", "shoulder.q2", {1e-7, 400, 1});
  expect_exact(bench, {creep}, 10, 5);
}

TEST(EffectDerivatives, AreExactForAScrewThatGrows) {
  const Bench bench = test::parallel_bench();
  for (const double grows : {0, 1, 2})
    expect_exact(
        bench,
        {test::effect(bench.manipulator, "thermal_expansion", "y.rho", {2.3e-5, 21, 15, grows})},
        50, 1);
}

// Where there is none yet its first trace is known, too: a search for effects starts there.
TEST_P(EveryEffect, HasExactDerivativesAtNone) {
  const Effect& given = effect();
  Effect none = given;
  none.values[0] = given.kind->parameters[0].none;
  Effect small = none;
  const double h = 1e-4 * (given.values[0] - none.values[0]);
  small.values[0] += h;
  Random random(5);
  const std::vector<ModelParameter> first = {{{}, 0, 0}};
  for (int path_number = 0; path_number < 5; ++path_number) {
    const std::vector<Step> path = random_path(bench(), random, 3);
    const auto exact =
        follow(EffectModel(bench().manipulator, {none}, tight), bench().posture, path, first);
    const auto near =
        follow(EffectModel(bench().manipulator, {small}, tight), bench().posture, path, {});
    for (std::size_t k = 0; k < path.size(); ++k) {
      const Vector6 column = exact[k].derivatives.col(0);
      const Vector6 difference = spatial::pose_difference(exact[k].observed, near[k].observed) / h;
      // One-sided, since none is often a bound: the error is of first order in h.
      EXPECT_LT((difference - column).norm(), 2e-3 * column.norm() + 1e-14 / std::abs(h))
          << effect().name_of(0) << " step " << k << "\n"
          << column.transpose() << "\n"
          << difference.transpose();
    }
  }
}

TEST_P(EveryEffect, OfSizeNoneIsNone) {
  Effect none = effect();
  for (std::size_t p = 0; p < none.kind->parameters.size(); ++p) {
    const bool is_shape = p > 0 && none.kind->parameters[p].required;
    if (!is_shape) none.values[static_cast<Eigen::Index>(p)] = none.kind->parameters[p].none;
  }
  Random random(3);
  const std::vector<Step> path = random_path(bench(), random, 10);
  const auto with =
      follow(EffectModel(bench().manipulator, {none}, tight), bench().posture, path, {});
  const auto without =
      follow(EffectModel(bench().manipulator, {}, tight), bench().posture, path, {});
  for (std::size_t k = 0; k < path.size(); ++k)
    EXPECT_LT(spatial::pose_difference(with[k].observed, without[k].observed).norm(), 1e-14);
}

// Where a fit may end.
TEST_P(EveryEffect, ActsWithAllValuesAtTheirBounds) {
  for (const double EffectParameter::*bound : {&EffectParameter::lower, &EffectParameter::upper}) {
    Effect at_bounds = effect();
    for (Eigen::Index k = 0; k < at_bounds.values.size(); ++k)
      if (const auto& p = at_bounds.kind->parameters[static_cast<std::size_t>(k)];
          p.usual_linear.empty() && at_bounds.values[k] != p.none)
        at_bounds.values[k] = p.*bound;
    EXPECT_NO_THROW(EffectModel(bench().manipulator, {at_bounds}, tight)) << effect().kind->name;
  }
}

TEST_P(EveryEffect, ChangesSomething) {
  Random random(4);
  const std::vector<Step> path = random_path(bench(), random, 3);
  const auto with =
      follow(EffectModel(bench().manipulator, {effect()}, tight), bench().posture, path, {});
  const auto without =
      follow(EffectModel(bench().manipulator, {}, tight), bench().posture, path, {});
  EXPECT_GT(spatial::pose_difference(with[2].observed, without[2].observed).norm(), 1e-10);
}

// Two effects together are one joint model, whichever comes first: every pair.
TEST_P(EveryEffect, ComposesWithEveryOtherInEitherOrder) {
  Random random(6);
  const std::vector<Step> path = random_path(bench(), random, 3);
  for (const Effect& other : bench().effects) {
    const auto one = follow(EffectModel(bench().manipulator, {effect(), other}, tight),
                            bench().posture, path, {});
    const auto two = follow(EffectModel(bench().manipulator, {other, effect()}, tight),
                            bench().posture, path, {});
    for (std::size_t k = 0; k < path.size(); ++k)
      EXPECT_LT(spatial::pose_difference(one[k].observed, two[k].observed).norm(), 2e-14)
          << effect().kind->name << " and " << other.kind->name;
  }
}

// All together, with the springs they act on: what one carries along the path moves the others.
TEST(Effects, AllTogetherHaveExactDerivatives) {
  for (const Bench& bench : {test::parallel_bench(), test::arm_bench(), shared_mounts()})
    expect_exact(bench, bench.effects, 1, 4);
}

TEST(Effects, AreAllOnABench) {
  std::set<std::string> parallel, arm;
  for (const Effect& effect : test::parallel_bench().effects) parallel.insert(effect.kind->name);
  for (const Effect& effect : test::arm_bench().effects) arm.insert(effect.kind->name);
  parallel.insert("joint_coupling");  // its chains have one drive each
  for (const Effect& effect : turned_arm().effects) arm.insert(effect.kind->name);
  for (const auto& kind : effect_kinds()) {
    EXPECT_TRUE(parallel.contains(kind->name)) << kind->name;
    EXPECT_TRUE(arm.contains(kind->name)) << kind->name;
  }
}

TEST(Effects, SayWhatTheyAre) {
  for (const auto& kind : effect_kinds()) {
    for (const std::string& text :
         {kind->summary, kind->law, kind->source, kind->signature, kind->confuser})
      EXPECT_FALSE(text.empty()) << kind->name;
    for (const EffectParameter& p : kind->parameters) {
      EXPECT_LT(p.lower, p.upper) << kind->name << " " << p.name;
      EXPECT_GT(p.prior_sd, 0) << kind->name << " " << p.name;
    }
  }
}

// The effect beside others, by condensation and in full: poses, derivatives and histories along
// paths. Returns how many equilibria could be condensed.
int expect_same_condensed(const Bench& bench, std::vector<Effect> effects, const Effect& effect,
                          int paths) {
  const EffectModel without(bench.manipulator, effects, tight);
  effects.push_back(effect);
  const EffectModel with(bench.manipulator, effects, tight);
  std::vector<ModelParameter> parameters;
  for (Eigen::Index v = 0; v < effect.values.size(); ++v)
    parameters.push_back({{}, effects.size() - 1, v});
  const EffectSite& site = effect.sites[0];
  const Chain& chain = bench.manipulator.chains()[site.chain];
  const JointPlace joint{site.chain, chain.index_of(site.element)};
  for (const Spring& spring : chain.springs())
    if (spring.first == joint.coordinate && spring.stiffness.rows() == 1)
      parameters.push_back({{{site.chain, spring.name}}, 0, 0});
  Random random(13);
  int condensed = 0;
  Response quick;  // in the memory of the one before
  for (int number = 0; number < paths; ++number) {
    Response before = with.at_rest(parameters.size());
    for (const Step& step : random_path(bench, random, 5)) {
      const Response full =
          with.respond(bench.posture, step.load, step.conditions, before, parameters, true);
      const auto state = without.condensed(bench.posture, step.load, step.conditions, {joint});
      const bool is_known =
          state && with.respond(*state, step.load, step.conditions, before, parameters, quick);
      before = full;
      if (!is_known) continue;
      ++condensed;
      const std::string where = effect.kind->name + ", path " + std::to_string(number);
      EXPECT_LT(spatial::pose_difference(full.observed, quick.observed).norm(), 1e-13) << where;
      for (Eigen::Index p = 0; p < full.derivatives.cols(); ++p)
        EXPECT_LE((full.derivatives.col(p) - quick.derivatives.col(p)).norm(),
                  1e-6 * full.derivatives.col(p).norm())
            << where << ", parameter " << p;
      const auto last = effects.size() - 1;
      EXPECT_LE((full.histories[last] - quick.histories[last]).norm(),
                1e-8 * full.histories[last].norm())
          << where;
      EXPECT_LE((full.history_derivatives[last] - quick.history_derivatives[last]).norm(),
                1e-7 * full.history_derivatives[last].norm())
          << where;
    }
  }
  return condensed;
}

using JointEffect = EveryEffect;

std::vector<std::pair<int, std::size_t>> every_effect_of_one_joint() {
  std::vector<std::pair<int, std::size_t>> some;
  for (const auto& [bench, e] : every_effect()) {
    const Effect& effect = bench_number(bench).effects[e];
    if (effect.kind->acts_on_joint_alone && effect.sites.size() == 1) some.emplace_back(bench, e);
  }
  return some;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, JointEffect, testing::ValuesIn(every_effect_of_one_joint()),
                         name_of);

TEST_P(JointEffect, FollowsFromTheCondensedModel) {
  Effect small = effect();
  // Which would push a passive joint farther than it is known.
  if (small.kind->name == "gravity_compensator") small.values[0] /= 20;
  EXPECT_GT(expect_same_condensed(bench(), {}, small, 10), 40);
}

// The energy, which no equilibrium is sought with, against the force, and that against the tangent.
TEST_P(JointEffect, HasLawsThatDeriveFromTheirEnergy) {
  const Manipulator with = with_effects(bench().manipulator, {effect()});
  const Chain& chain = with.chains()[effect().sites[0].chain];
  for (const auto& [k, law] : chain.laws()) {
    const double stiffness = chain.stiffness()(k, k), command = 0.3;
    const auto at = [&](double d) {
      return CoordinateLaw::JointState{command + d, d, stiffness, d};
    };
    for (const double d : {-2.3e-3, -4e-4, -3e-5, 7e-6, 2e-4, 1.7e-3}) {
      const double h = 1e-8;
      const CoordinateLaw::Value here = law->at(at(d)), above = law->at(at(d + h)),
                                 below = law->at(at(d - h));
      const double by_energy = (law->energy(at(d + h)) - law->energy(at(d - h))) / (2 * h);
      const double size = std::abs(here.force) + stiffness * std::abs(d);
      EXPECT_NEAR(by_energy, here.force, 1e-5 * size) << effect().kind->name << " at " << d;
      EXPECT_NEAR((above.force - below.force) / (2 * h), here.tangent,
                  1e-3 * (stiffness + std::abs(here.tangent)) + 1e-15 * size / h)
          << effect().kind->name << " at " << d;
    }
  }
}

// Whose corners are narrow beside the way that the other joint goes.
TEST(CondensedModel, KnowsLawsInOtherJoints) {
  const Bench bench = test::arm_bench();
  const Manipulator& m = bench.manipulator;
  const std::vector<Effect> others = {test::effect(m, "clearance", "arm.q4", {2e-4, 0}),
                                      test::effect(m, "directional_stiffness", "arm.q5", {1.7}),
                                      test::effect(m, "sensor_scale", "sensor", {2e-3}),
                                      test::effect(m, "wrench_gain", "load", {1.1})};
  EXPECT_GT(
      expect_same_condensed(bench, others, test::effect(m, "creep", "arm.q3", {1e-9, 400, 0}), 20),
      50);
  EXPECT_GT(
      expect_same_condensed(bench, others, test::effect(m, "hardening", "arm.q4", {1e10}), 20), 50);
}

// What acts on the readings alone, and what does nothing without a temperature.
TEST(CondensedModel, KnowsWhatLeavesTheEquilibrium) {
  const Bench bench = test::arm_bench();
  const Manipulator& m = bench.manipulator;
  const std::vector<Effect> others = {
      test::effect(m, "clearance", "arm.q4", {2e-4, 0}),
      test::effect(m, "sensor_frame", "sensor", {1e-3, 0, 2e-3, 1e-3, 0, -2e-3})};
  const EffectModel without(m, others, tight);
  const Load load{.force = {30, -20, 50}, .moment = {1, 2, 3}};
  const Conditions conditions{.time = 300};
  const auto state = without.condensed(bench.posture, load, conditions, {});
  ASSERT_TRUE(state);
  for (const Effect& effect :
       {test::effect(m, "sensor_scale", "sensor", {2e-3}),
        test::effect(m, "session_drift", "sensor", {3e-8, -2e-8, 1e-8, 4e-8, 2e-8, -1e-8, 0.7}),
        test::effect(m, "thermal_expansion", "arm.forearm", {1.2e-5, 22, 0, 0})}) {
    std::vector<Effect> effects = others;
    effects.push_back(effect);
    const EffectModel with(m, effects, tight);
    std::vector<ModelParameter> parameters;
    for (Eigen::Index v = 0; v < effect.values.size(); ++v)
      parameters.push_back({{}, effects.size() - 1, v});
    const Response rest = with.at_rest(parameters.size());
    const Response full = with.respond(bench.posture, load, conditions, rest, parameters, true);
    Response quick;
    ASSERT_TRUE(with.respond(*state, load, conditions, rest, parameters, quick))
        << effect.kind->name;
    EXPECT_LT(spatial::pose_difference(full.observed, quick.observed).norm(), 1e-13);
    EXPECT_LE((full.derivatives - quick.derivatives).norm(), 1e-12 * full.derivatives.norm());
    parameters.push_back({{{0, "q3"}}, 0, 0});  // which moves the robot
    EXPECT_FALSE(
        with.respond(*state, load, conditions, with.at_rest(parameters.size()), parameters, quick));
  }
}

TEST(CondensedModel, LeavesAloneWhatItCannotKnow) {
  const Bench bench = test::arm_bench();
  const Manipulator& m = bench.manipulator;
  const auto expect_none = [&](const std::vector<Effect>& effects, const char* joint) {
    const EffectModel without(m, {effects.begin(), effects.end() - 1}, tight);
    const EffectSite& site = effects.back().sites[0];
    const JointPlace place{site.chain, m.chains()[site.chain].index_of(joint)};
    const auto state = without.condensed(bench.posture, {}, {}, {place});
    const EffectModel with(m, effects, tight);
    Response response;
    EXPECT_FALSE(state && with.respond(*state, {}, {}, with.at_rest(0), {}, response))
        << effects.back().kind->name;
  };
  // Another sort of effect, one that moves its joint far, and one beside a history in its joint.
  expect_none({test::effect(m, "link_compliance", "forearm", {1.4})}, "q3");
  expect_none({test::effect(m, "preload", "arm.q3", {1e6})}, "q3");
  expect_none({test::effect(m, "friction", "arm.q3", {60, 5e-5, 0, 0}),
               test::effect(m, "preload", "arm.q3", {200})},
              "q3");
}

// Histories in other joints are those without the effect, and with these each state is exact.
TEST(CondensedModel, TakesHistoriesOfOtherJointsAsTheyAre) {
  const Bench bench = test::arm_bench();
  const Manipulator& m = bench.manipulator;
  const std::vector<Effect> others = {test::effect(m, "friction", "arm.q5", {60, 5e-5, 0, 1}),
                                      test::effect(m, "creep", "shoulder.q2", {1e-7, 400, 0})};
  const EffectModel without(m, others, tight);
  const std::size_t arm = others[0].sites[0].chain;
  const JointPlace joint{arm, m.chains()[arm].index_of("q4")};
  Random random(17);
  const std::vector<Step> path = random_path(bench, random, 8);
  for (const Effect& effect : {test::effect(m, "friction", "arm.q4", {40, 5e-5, 0, 0}),
                               test::effect(m, "sensor_scale", "sensor", {2e-3})}) {
    std::vector<Effect> effects = others;
    effects.push_back(effect);
    const EffectModel with(m, effects, tight);
    const std::vector<ModelParameter> parameters = {{{}, 2, 0}};
    Response before = with.at_rest(1), before_without = without.at_rest(0), quick;
    int condensed = 0;
    for (const Step& step : path) {
      const auto state = without.condensed(bench.posture, step.load, step.conditions, {joint},
                                           nullptr, before_without.histories);
      ASSERT_TRUE(state);
      const Response full =
          with.respond(bench.posture, step.load, step.conditions, before, parameters, true);
      const bool is_known =
          with.respond(*state, step.load, step.conditions, before, parameters, quick);
      before_without =
          without.respond(bench.posture, step.load, step.conditions, before_without, {}, false);
      for (std::size_t e = 0; e < 2; ++e)
        EXPECT_LT((state->after[e] - before_without.histories[e]).norm(), 1e-12);
      before = with.at_rest(1);
      std::copy_n(before_without.histories.begin(), 2, before.histories.begin());
      before.histories[2] = full.histories[2];
      if (!is_known) continue;
      ++condensed;
      EXPECT_LT(spatial::pose_difference(full.observed, quick.observed).norm(), 1e-12);
      EXPECT_LE((full.derivatives - quick.derivatives).norm(), 1e-6 * full.derivatives.norm());
      EXPECT_LT((full.histories[2] - quick.histories[2]).norm(), 1e-8);
      EXPECT_EQ(quick.histories[0], state->after[0]);
    }
    EXPECT_GT(condensed, 5) << effect.kind->name;
  }
}

}  // namespace
}  // namespace kinetostat::vjm::effect_catalogue_test
