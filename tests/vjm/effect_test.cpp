#include "kinetostat/vjm/effect.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "kinetostat/vjm/posture.h"
#include "kinetostat/vjm/robot_file.h"

namespace kinetostat::vjm {
namespace {

using spatial::Vector6;

Robot shipped(const char* name) {
  return read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name);
}

Effect effect(const char* kind, std::size_t chain, const char* element,
              std::initializer_list<double> values) {
  Effect result{.kind = &effect_kind(kind), .chain = chain, .element = element, .values = {}};
  result.values =
      Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
  return result;
}

// One spring along z, 1e6 N/m.
Manipulator bench() {
  Chain chain("cell");
  chain.actuator("spring", Motion::tz, 1e6);
  return Manipulator("bench", {chain}).with_gravity({0, 0, -10});
}

double deflection(const std::vector<Effect>& effects, double force) {
  const Manipulator m = with_effects(bench(), effects);
  const Equilibrium e =
      equilibrium_under_load(m, posture_from_joints(m, {}).posture, {.force = {0, 0, force}});
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return e.displacement.translation.z();
}

// Central differences of fourth order against the exact derivatives, at random loads.
void expect_exact(const Manipulator& m, const Posture& posture, std::vector<Effect> effects,
                  double force, double moment, double tolerance = 1e-14) {
  const EquilibriumOptions tight{.tolerance = tolerance};
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double size) {
    return spatial::Vector3(size * uniform(engine), size * uniform(engine), size * uniform(engine));
  };
  for (int state = 0; state < 100; ++state) {
    const Load load{.force = vector(force), .moment = vector(moment)};
    const Manipulator changed = with_effects(m, effects);
    const Equilibrium e = equilibrium_under_load(changed, posture, load, tight);
    ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    const Matrix6X exact = displacement_by_effects(changed, posture, load, e, effects);
    Eigen::Index column = 0;
    for (Effect& shifted : effects)
      for (Eigen::Index p = 0; p < shifted.values.size(); ++p, ++column) {
        const double value = shifted.values[p], h = 2e-3 * std::abs(value);
        const auto pose = [&](double steps) {
          shifted.values[p] = value + steps * h;
          return equilibrium_under_load(with_effects(m, effects), posture, load, tight).platform;
        };
        const Vector6 near = spatial::pose_difference(pose(-1), pose(1));
        const Vector6 far = spatial::pose_difference(pose(-2), pose(2));
        shifted.values[p] = value;
        const Vector6 numerical = (8 * near - far) / (12 * h);
        // The second term is the rounding of the solutions themselves.
        EXPECT_LT((numerical - exact.col(column)).norm(),
                  1e-6 * exact.col(column).norm() + 1e-13 / h)
            << shifted.kind->name << " " << p << " state " << state;
      }
  }
}

TEST(Effects, AreExactlyDifferentiatedOnAParallelRobot) {
  const Manipulator m = shipped("orthoglide.yaml").manipulator.with_gravity({0, 0, -9.81});
  const Posture posture = posture_at(m, spatial::Pose::translation({0.05, -0.03, 0.02})).posture;
  expect_exact(
      m, posture,
      {effect("joint_compliance", 0, "rho", {1e-6}), effect("link_compliance", 1, "leg", {1.3}),
       effect("hardening", 1, "rho", {1e19}), effect("preload", 2, "rho", {50}),
       effect("payload", 0, "", {5, 0.02, 0.01, -0.03})},
      300, 10, 1e-15);
}

TEST(Effects, AreExactlyDifferentiatedOnASerialRobot) {
  const Manipulator m = shipped("six_axis.yaml").manipulator.with_gravity({0, 0, -9.81});
  const Posture posture = posture_from_joints(m, {}).posture;
  expect_exact(m, posture,
               {effect("joint_compliance", 0, "q1", {1e-7}), effect("hardening", 0, "q2", {1e12}),
                effect("preload", 0, "q3", {100}), effect("clearance", 0, "q4", {2e-4}),
                effect("payload", 0, "", {50, 0.1, 0.05, -0.1})},
               1000, 200);
}

TEST(Effects, OnOneJointComposeInEitherOrder) {
  const Effect compliance = effect("joint_compliance", 0, "spring", {4e-7});
  const Effect gap = effect("clearance", 0, "spring", {1e-4});
  const Effect hard = effect("hardening", 0, "spring", {3e12});
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
    for (const char* kind : {"joint_compliance", "hardening", "clearance", "preload"})
      EXPECT_NEAR(deflection({effect(kind, 0, "spring", {0})}, force), plain, 1e-17) << kind;
    EXPECT_NEAR(deflection({effect("payload", 0, "", {0, 0.1, 0.2, 0.3})}, force), plain, 1e-17);
  }
}

TEST(Effects, FollowTheirLaws) {
  EXPECT_NEAR(deflection({effect("joint_compliance", 0, "spring", {1e-6})}, 500), 1e-3, 1e-15);
  EXPECT_NEAR(deflection({effect("preload", 0, "spring", {200})}, 500), 7e-4, 1e-15);
  EXPECT_NEAR(deflection({effect("payload", 0, "", {20, 0, 0, 0})}, 500), 3e-4, 1e-15);
  // k d + k3 d^3 at d = 1e-3: 1000 N + 500 N.
  EXPECT_NEAR(deflection({effect("hardening", 0, "spring", {5e11})}, 1500), 1e-3, 1e-13);
  // Far beyond the gap the joint has lost just the gap: w^2/4 (1/(d+g) - 1/(d-g)) is left.
  EXPECT_NEAR(deflection({effect("clearance", 0, "spring", {1e-5})}, 1000), 1.01e-3, 1e-10);
  EXPECT_NEAR(deflection({effect("clearance", 0, "spring", {1e-5})}, -1000), -1.01e-3, 1e-10);
}

TEST(Effects, AreRefusedWhereTheyCannotAct) {
  Chain chain("c");
  chain.actuator("rigid", Motion::rz, std::nullopt);
  const Manipulator m("m", {chain});
  for (const char* kind : {"joint_compliance", "hardening", "clearance", "preload"})
    EXPECT_THROW(with_effects(m, {effect(kind, 0, "rigid", {1})}), std::invalid_argument) << kind;
  EXPECT_THROW(with_effects(m, {effect("link_compliance", 0, "leg", {1})}), std::invalid_argument);
  EXPECT_THROW(effect_kind("hardning"), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm
