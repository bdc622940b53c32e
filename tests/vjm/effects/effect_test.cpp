#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"

namespace kinetostat::vjm::effect_test {
namespace {

using spatial::Vector6;

Robot shipped(const char* name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

Effect effect(const Manipulator& m, const char* kind, const char* at,
              std::initializer_list<double> values) {
  Effect result{.kind = effect_kind(kind), .at = at, .sites = {}, .values = {}};
  result.sites = effect_sites(*result.kind, m, at);
  result.values =
      Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
  return result;
}

std::vector<ModelParameter> all_values(const std::vector<Effect>& effects) {
  std::vector<ModelParameter> parameters;
  for (std::size_t e = 0; e < effects.size(); ++e)
    for (Eigen::Index v = 0; v < effects[e].values.size(); ++v) parameters.push_back({{}, e, v});
  return parameters;
}

// One spring along z, 1e6 N/m.
Manipulator bench() {
  ChainBuilder chain("cell");
  chain.actuator("spring", Motion::tz, 1e6);
  return Manipulator("bench", {chain.build()}).with_gravity({0, 0, -10});
}

double deflection(const std::vector<Effect>& effects, double force) {
  const Manipulator m = with_effects(bench(), effects);
  const Equilibrium e =
      equilibrium_under_load(m, posture_from_joints(m, {}).posture, {.force = {0, 0, force}});
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return e.displacement.translation.z();
}

// Central differences of fourth order against the exact derivatives, at random loads.
void expect_exact(const Manipulator& m, const Posture& posture, const std::vector<Effect>& effects,
                  double force, double moment, double tolerance = 1e-14) {
  const EquilibriumOptions tight{.tolerance = tolerance};
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double size) {
    return spatial::Vector3(size * uniform(engine), size * uniform(engine), size * uniform(engine));
  };
  const std::vector<ModelParameter> parameters = all_values(effects);
  for (int state = 0; state < 100; ++state) {
    const Load load{.force = vector(force), .moment = vector(moment)};
    const EffectModel model(m, effects, tight);
    const Response exact =
        model.respond(posture, load, {}, model.at_rest(parameters.size()), parameters, true);
    ASSERT_TRUE(exact.failure.empty()) << exact.failure;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const auto& [springs, e, v] = parameters[p];
      const double value = effects[e].values[v], h = 2e-3 * std::abs(value == 0 ? 1 : value);
      const auto pose = [&, e = e, v = v](double steps) {
        std::vector<Effect> shifted = effects;
        shifted[e].values[v] = value + steps * h;
        const EffectModel other(m, shifted, tight);
        return other.respond(posture, load, {}, other.at_rest(0), {}, false).observed;
      };
      const Vector6 near = spatial::pose_difference(pose(-1), pose(1));
      const Vector6 far = spatial::pose_difference(pose(-2), pose(2));
      const Vector6 numerical = (8 * near - far) / (12 * h);
      const Vector6 column = exact.derivatives.col(static_cast<Eigen::Index>(p));
      // The second term is the rounding of the solutions themselves.
      EXPECT_LT((numerical - column).norm(), 1e-6 * column.norm() + 1e-13 / h)
          << effects[e].name_of(v) << " state " << state;
    }
  }
}

TEST(Effects, AreExactlyDifferentiatedOnAParallelRobot) {
  const Manipulator m = shipped("orthoglide.yaml").manipulator.with_gravity({0, 0, -9.81});
  const Posture posture = posture_at(m, spatial::Pose::translation({0.05, -0.03, 0.02})).posture;
  expect_exact(
      m, posture,
      {effect(m, "joint_compliance", "x.rho", {1e-6}), effect(m, "link_compliance", "y.leg", {1.3}),
       effect(m, "hardening", "y.rho", {1e19}), effect(m, "preload", "z.rho", {50}),
       effect(m, "payload", "platform", {5, 0.02, 0.01, -0.03})},
      300, 10, 1e-15);
}

TEST(Effects, AreExactlyDifferentiatedOnASerialRobot) {
  const Manipulator m = shipped("six_axis.yaml").manipulator.with_gravity({0, 0, -9.81});
  const Posture posture = posture_from_joints(m, {}).posture;
  expect_exact(m, posture,
               {effect(m, "joint_compliance", "q1", {1e-7}), effect(m, "hardening", "q2", {1e12}),
                effect(m, "preload", "q3", {100}), effect(m, "clearance", "q4", {2e-4, 0}),
                effect(m, "payload", "platform", {50, 0.1, 0.05, -0.1})},
               1000, 200);
}

TEST(Effects, OnOneJointComposeInEitherOrder) {
  const Effect compliance = effect(bench(), "joint_compliance", "spring", {4e-7});
  const Effect gap = effect(bench(), "clearance", "spring", {1e-4, 0});
  const Effect hard = effect(bench(), "hardening", "spring", {3e12});
  const double force = 700;
  const double d = deflection({compliance, gap, hard}, force);
  EXPECT_EQ(d, deflection({hard, gap, compliance}, force));
  // The joint model, written down: k dead(d) + k3 d^3 = F with 1/k = 1/k0 + c.
  const double k = 1 / (1e-6 + 4e-7), g = 1e-4, w = 0.2 * g;
  const double dead = d + (std::hypot(d - g, w) - std::hypot(d + g, w)) / 2;
  EXPECT_NEAR(k * dead + 3e12 * d * d * d, force, 1e-7);
  const Manipulator m = bench();
  expect_exact(m, posture_from_joints(m, {}).posture, {compliance, gap, hard}, 2000, 0, 1e-16);
}

TEST(Effects, OfSizeZeroAreNone) {
  for (const double force : {-800.0, -3.0, 0.5, 900.0}) {
    const double plain = deflection({}, force);
    EXPECT_NEAR(plain, force / 1e6, 1e-17);
    EXPECT_NEAR(deflection({effect(bench(), "clearance", "spring", {0, 1})}, force), plain, 1e-17);
    for (const char* kind : {"joint_compliance", "hardening", "load_hardening", "preload"})
      EXPECT_NEAR(deflection({effect(bench(), kind, "spring", {0})}, force), plain, 1e-17) << kind;
    EXPECT_NEAR(deflection({effect(bench(), "payload", "platform", {0, 0.1, 0.2, 0.3})}, force),
                plain, 1e-17);
  }
}

TEST(Effects, FollowTheirLaws) {
  EXPECT_NEAR(deflection({effect(bench(), "joint_compliance", "spring", {1e-6})}, 500), 1e-3,
              1e-15);
  EXPECT_NEAR(deflection({effect(bench(), "preload", "spring", {200})}, 500), 7e-4, 1e-15);
  EXPECT_NEAR(deflection({effect(bench(), "payload", "platform", {20, 0, 0, 0})}, 500), 3e-4,
              1e-15);
  // k d + k3 d^3 at d = 1e-3: 1000 N + 500 N.
  EXPECT_NEAR(deflection({effect(bench(), "hardening", "spring", {5e11})}, 1500), 1e-3, 1e-13);
  // F/k - b F^2: 1.5 mm less 0.225 mm.
  EXPECT_NEAR(deflection({effect(bench(), "load_hardening", "spring", {1e-10})}, 1500), 1.275e-3,
              1e-12);
  EXPECT_NEAR(deflection({effect(bench(), "load_hardening", "spring", {1e-10})}, -1500), -1.275e-3,
              1e-12);
  // Far beyond the gap the joint has lost just the gap: w^2/4 (1/(d+g) - 1/(d-g)) is left.
  EXPECT_NEAR(deflection({effect(bench(), "clearance", "spring", {1e-5, 0})}, 1000), 1.01e-3,
              1e-10);
  EXPECT_NEAR(deflection({effect(bench(), "clearance", "spring", {1e-5, 0})}, -1000), -1.01e-3,
              1e-10);
}

// Also where the law has ended: beyond 450 N the spring is ten times as stiff as without load. The
// size for the derivatives is one with which no state lies so near the end that differences
// straddle it.
TEST(Effects, LoadHardeningIsExactlyDifferentiatedOnBothSidesOfItsEnd) {
  const Manipulator m = bench();
  expect_exact(m, posture_from_joints(m, {}).posture,
               {effect(m, "load_hardening", "spring", {1.2e-9})}, 2000, 0, 1e-16);
  const Effect hard = effect(m, "load_hardening", "spring", {1e-9});
  const double end = 4.5e-4 - 1e-9 * 450 * 450;
  EXPECT_NEAR(deflection({hard}, 450), end, 1e-12);
  EXPECT_NEAR(deflection({hard}, 1450), end + 1000 / 1e7, 1e-12);
}

// Positions of the bench along a path of loads, from rest.
std::vector<double> positions(const std::vector<Effect>& effects,
                              const std::vector<double>& forces) {
  const EffectModel model(bench(), effects, {.tolerance = 1e-15});
  const Posture posture = posture_from_joints(bench(), {}).posture;
  Response before = model.at_rest(0);
  std::vector<double> result;
  for (const double force : forces) {
    before = model.respond(posture, {.force = {0, 0, force}}, {}, before, {}, false);
    EXPECT_TRUE(before.failure.empty()) << before.failure;
    result.push_back(before.observed.position().z());
  }
  return result;
}

// Work of the load over a closed path, by the trapezoidal rule.
double work(const std::vector<double>& force, const std::vector<double>& position) {
  double sum = 0;
  for (std::size_t i = 1; i < force.size(); ++i)
    sum += (force[i] + force[i - 1]) / 2 * (position[i] - position[i - 1]);
  return sum;
}

// The second round of a cycle is closed in the state of the friction, too.
TEST(Effects, FrictionLosesEnergyOnEveryClosedCycle) {
  const Effect friction = effect(bench(), "friction", "spring", {100, 2e-5, 0, 0});
  const Effect gradual = effect(bench(), "friction", "spring", {100, 2e-5, 0, 1});
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int cycle = 0; cycle < 50; ++cycle) {
    std::vector<double> corners;
    for (int k = 0; k < 4; ++k) corners.push_back(800 * uniform(engine));
    corners.push_back(corners[0]);
    std::vector<double> path = {0};
    for (int round = 0; round < 3; ++round)
      for (std::size_t k = 0; k + 1 < corners.size(); ++k)
        for (int i = 0; i < 40; ++i)
          path.push_back(corners[k] + (corners[k + 1] - corners[k]) * i / 40.0);
    const std::vector<double> z = positions({cycle % 2 == 0 ? friction : gradual}, path);
    const std::size_t length = 160, begin = path.size() - length;
    const std::vector<double> last_path(path.begin() + static_cast<long>(begin) - 1, path.end());
    std::vector<double> last(z.begin() + static_cast<long>(begin) - 1, z.end());
    EXPECT_GE(work(last_path, last), -1e-12) << cycle;
  }
  // A wide cycle: slip over 2 (800 - 100) N / k less the presliding, at 100 N either way.
  std::vector<double> wide = {0};
  for (int round = 0; round < 2; ++round)
    for (const double end : {800.0, -800.0, 0.0}) {
      const double start = wide.back();
      for (int i = 1; i <= 400; ++i) wide.push_back(start + (end - start) * i / 400.0);
    }
  const std::vector<double> z = positions({friction}, wide);
  const std::vector<double> force(wide.begin() + 1200, wide.end());
  const std::vector<double> position(z.begin() + 1200, z.end());
  // Travel between the reversals: 1400 N / k; sticking and its rounded end take 2 e (1 +- 0.05).
  const double slip = 1400.0 / 1e6 - 2 * 2e-5;
  EXPECT_NEAR(work(force, position), 2 * 100 * slip, 2 * 100 * 2e-6);
}

// Dahl's law between reversals, dF/dx = (force - F) / presliding on the way up and
// (force + F) / presliding on the way down, whatever the number of readings on the way.
TEST(Effects, GradualFrictionFollowsDahlsLaw) {
  const double k = 1e6, limit = 100, length = 2e-5;
  const Effect friction = effect(bench(), "friction", "spring", {limit, length, 0, 1});
  std::vector<double> path = {0};
  for (const double end : {180.0, -60.0, 90.0, -400.0}) {
    const double start = path.back();
    for (int i = 1; i <= 8; ++i) path.push_back(start + (end - start) * i / 8);
  }
  for (const std::size_t every : {1, 8}) {
    std::vector<double> seen;
    for (std::size_t i = 0; i < path.size(); i += every) seen.push_back(path[i]);
    const std::vector<double> x = positions({friction}, seen);
    double turned = 0, force = 0, before = 0;
    for (std::size_t i = 1; i < seen.size(); ++i) {
      const std::size_t reversals = (i * every - 1) / 8;
      if ((i - 1) * every % 8 == 0) turned = before, force = seen[i - 1] - k * before;
      const double up = reversals % 2 == 0 ? 1 : -1;
      const double held =
          up * limit + (force - up * limit) * std::exp(-std::abs(x[i] - turned) / length);
      EXPECT_NEAR(k * x[i] + held, seen[i], 1e-8) << every << ", " << i;
      before = x[i];
    }
  }
}

// From where the joint slips either way Newton's method must pass the steep part between, whose
// stiffness is 1e5 times the spring's; it takes the few corrections that it is given.
TEST(Effects, FrictionIsCrossedInAFewCorrections) {
  const double k = 1e6, limit = 100, presliding = 1e-9, stuck = 5e-4;
  const Effect friction = effect(bench(), "friction", "spring", {limit, presliding, 0, 0});
  const Manipulator m =
      with_effects(bench(), {friction}, {}, {Eigen::Vector2d(0, stuck)});  // stretch and travel
  const Posture posture = posture_from_joints(m, {}).posture;
  for (const double change : {0.0, 60.0, -90.0, 300.0, -300.0})
    for (const double away : {1e-3, -1e-3}) {
      const EquilibriumSystem system(m, posture);
      SystemState near = system.relaxed_state();
      near.coordinates[0][0] += stuck + away;
      const Load load{.force = {0, 0, k * stuck + change}};
      const FoundState found = state_under_load(system, load, {.max_iterations = 6}, &near);
      ASSERT_EQ(found.status, EquilibriumStatus::converged);
      EXPECT_EQ(found.steps, 1);
      const double moved = std::abs(change) < limit ? change / (k + limit / presliding)
                                                    : (change - std::copysign(limit, change)) / k;
      EXPECT_NEAR(found.state.bodies[0].position().z(), stuck + moved, 1e-15);
    }
}

// A start that is near changes the cost and not the solution.
TEST(Effects, AStartThatIsNearLeadsToTheSameEquilibrium) {
  for (const char* name : {"orthoglide.yaml", "six_axis.yaml"}) {
    const Manipulator m = shipped(name).manipulator;
    const Posture posture = posture_at(m, {}).posture;
    const EquilibriumSystem system(m, posture);
    const Load load{.force = {300, -200, 400}, .moment = {20, 10, -15}};
    const EquilibriumOptions options;
    const SystemState exact = state_under_load(system, load, options).state;
    for (const double share : {0.0, 0.8, 0.999}) {
      const SystemState near = state_under_load(system, load.scaled(share), options).state;
      const FoundState found = state_under_load(system, load, options, &near);
      ASSERT_EQ(found.status, EquilibriumStatus::converged);
      EXPECT_LT(spatial::pose_difference(exact.bodies[0], found.state.bodies[0]).norm(), 1e-14);
      for (std::size_t c = 0; c < m.size(); ++c)
        EXPECT_LT((exact.coordinates[c] - found.state.coordinates[c]).norm(), 1e-13);
    }
  }
}

TEST(Effects, FrictionWithoutForceIsNoneAndCreepWithoutTimeIsNone) {
  std::vector<double> path;
  for (int i = 0; i < 40; ++i) path.push_back(700 * std::sin(0.5 * i));
  const std::vector<double> plain = positions({}, path);
  const std::vector<double> none =
      positions({effect(bench(), "friction", "spring", {0, 1e-5, 0, 0})}, path);
  const std::vector<double> at_once =
      positions({effect(bench(), "creep", "spring", {1e-6, 10, 0})}, path);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_NEAR(none[i], plain[i], 1e-18);
    EXPECT_NEAR(at_once[i], plain[i], 1e-18);
  }
}

// An arm of one material is larger in one proportion, and turns nothing.
TEST(Effects, AllPartsThatGrowMakeTheRobotLarger) {
  ChainBuilder chain("arm");
  chain.actuator("q1", Motion::rz, 1e5).offset(spatial::Pose::translation({0.5, 0, 0.2}));
  chain.actuator("q2", Motion::ry, 1e5).offset(spatial::Pose::translation({0.4, 0.1, 0}));
  chain.actuator("q3", Motion::rx, 1e5).offset(spatial::Pose::translation({0.1, 0, 0.05}));
  const Manipulator arm("arm", {chain.build()});
  const Posture posture = posture_from_joints(arm, {{"q1", 0.4}, {"q2", -0.7}, {"q3", 1}}).posture;
  const EffectModel model(arm, {effect(arm, "thermal_expansion", "all parts", {2e-5, 20, 0, 0})});
  const Response warm =
      model.respond(posture, {}, {.temperature = 30.0}, model.at_rest(0), {}, false);
  EXPECT_LT((warm.observed.position() - (1 + 2e-4) * posture.platform.position()).norm(), 1e-12);
  EXPECT_LT((warm.observed.rotation() - posture.platform.rotation()).norm(), 1e-12);
}

// A column that leads to a slide, and the screw of the slide, each by itself or together.
TEST(Effects, ThePartBeforeASlideGrowsByItselfOrItsScrewDoes) {
  ChainBuilder chain("gantry");
  chain.offset(spatial::Pose::translation({0.1, 0, 2}));
  chain.actuator("x", Motion::tx, 1e8).offset(spatial::Pose::translation({0, 0.5, 0}));
  const Manipulator gantry("gantry", {chain.build()});
  const Posture posture = posture_from_joints(gantry, {{"x", 0.8}}).posture;
  const spatial::Vector3 part(0.1, 0, 2), screw(0.8, 0, 0);
  const auto moved = [&](const char* at, double grows) -> spatial::Vector3 {
    const EffectModel model(gantry,
                            {effect(gantry, "thermal_expansion", at, {1e-5, 20, 0, grows})});
    return model.respond(posture, {}, {.temperature = 30.0}, model.at_rest(0), {}, false)
               .observed.position() -
           posture.platform.position();
  };
  EXPECT_LT((moved("x", 0) - 1e-4 * (part + screw)).norm(), 1e-12);
  EXPECT_LT((moved("x", 1) - 1e-4 * part).norm(), 1e-12);
  EXPECT_LT((moved("x", 2) - 1e-4 * screw).norm(), 1e-12);
  EXPECT_FALSE(can_act(effect(gantry, "thermal_expansion", "end", {1e-5, 20, 0, 1}), gantry));
}

// A held load: the spring, then c F (1 - exp(-t/tau)) more; taken away, it goes back.
TEST(Effects, CreepFollowsTheStandardLinearSolid) {
  const double c = 3e-7, tau = 120;
  const EffectModel model(bench(), {effect(bench(), "creep", "spring", {c, tau, 0})});
  const Posture posture = posture_from_joints(bench(), {}).posture;
  Response state = model.at_rest(0);
  const auto read = [&](double force, double elapsed) {
    Conditions conditions;
    conditions.elapsed = elapsed;
    state = model.respond(posture, {.force = {0, 0, force}}, conditions, state, {}, false);
    return state.observed.position().z();
  };
  EXPECT_NEAR(read(600, 0), 6e-4, 1e-15);
  EXPECT_NEAR(read(600, 60), 6e-4 + c * 600 * (1 - std::exp(-0.5)), 1e-15);
  EXPECT_NEAR(read(600, 180), 6e-4 + c * 600 * (1 - std::exp(-2)), 1e-15);
  EXPECT_NEAR(read(0, 0), c * 600 * (1 - std::exp(-2)), 1e-15);
  EXPECT_NEAR(read(0, 120), c * 600 * (1 - std::exp(-2)) * std::exp(-1), 1e-15);
}

TEST(Effects, AreRefusedWhereTheyCannotAct) {
  ChainBuilder chain("c");
  chain.actuator("rigid", Motion::rz, std::nullopt);
  const Manipulator m("m", {chain.build()});
  for (const char* kind : {"joint_compliance", "hardening", "preload"})
    EXPECT_THROW(with_effects(m, {effect(m, kind, "rigid", {1})}), std::invalid_argument) << kind;
  EXPECT_THROW(with_effects(m, {effect(m, "clearance", "rigid", {1, 0})}), std::invalid_argument);
  EXPECT_THROW(effect(m, "link_compliance", "leg", {1}), std::invalid_argument);
  EXPECT_THROW(effect(m, "preload", "rigit", {1}), std::invalid_argument);
  EXPECT_THROW(effect_kind("hardning"), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::effect_test
