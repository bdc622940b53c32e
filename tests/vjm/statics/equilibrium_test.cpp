#include "kinetostat/vjm/statics/equilibrium.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/random_chain.h"

namespace kinetostat::vjm::equilibrium_test {
namespace {

using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

const Robot& orthoglide() {
  static const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  return robot;
}

Posture orthoglide_at(double x, double y, double z) {
  const PostureResult result = posture_at(orthoglide().manipulator, Pose::translation({x, y, z}));
  EXPECT_TRUE(result.reached) << result.reason;
  return result.posture;
}

// A soft serial arm with links and joint springs: large rotations at moderate loads.
Manipulator arm(unsigned seed) {
  samples::RandomChains random(seed);
  ChainBuilder chain("arm");
  for (const char* name : {"q1", "q2", "q3"}) {
    chain.actuator(name, name[1] == '2' ? Motion::ry : Motion::rz, 2e3);
    chain.link("l" + std::string(name), Pose::translation({0.3, 0.02, 0.01}), random.compliance());
  }
  return Manipulator("arm", {chain.build()});
}

Posture arm_posture(const Manipulator& manipulator) {
  return posture_from_joints(manipulator, {{"q1", 0.4}, {"q2", -0.7}, {"q3", 1.1}}).posture;
}

// Wrench (at the platform point, base axes) that holds the platform at a displacement.
Vector6 holding_wrench(const Manipulator& manipulator, const Posture& posture, const Pose& pose) {
  const Equilibrium e = equilibrium_at_pose(manipulator, posture, pose);
  EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  return e.wrench.coordinates();
}

void expect_tangent_is_the_slope(const Manipulator& manipulator, const Posture& posture,
                                 const Pose& loaded, double translation, double rotation) {
  const Equilibrium e = equilibrium_at_pose(manipulator, posture, loaded);
  ASSERT_TRUE(e.stiffness);
  Matrix6 numerical;
  for (int j = 0; j < 6; ++j) {
    const double h = j < 3 ? translation : rotation;
    const auto at = [&](double factor) {
      const Vector6 step = factor * h * Vector6::Unit(j);
      return holding_wrench(manipulator, posture, spatial::displaced(loaded, step));
    };
    // Fourth-order central difference.
    numerical.col(j) = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h);
  }
  // Forces over translations, couplings and moments over rotations, each against its own size.
  const Matrix6& tangent = e.stiffness->matrix();
  const auto block = [](const Matrix6& m, int i, int j) {
    return Eigen::Matrix3d(m.block<3, 3>(i, j));
  };
  for (int i : {0, 3})
    for (int j : {0, 3}) {
      const double diagonals = block(tangent, i, i).norm() * block(tangent, j, j).norm();
      const double size = block(tangent, i, j).norm() + 1e-2 * std::sqrt(diagonals);
      EXPECT_LT(block(numerical - tangent, i, j).norm(), 1e-6 * size) << i << ", " << j;
    }
}

TEST(Equilibrium, TangentStiffnessIsTheSlopeOfTheForceDeflectionRelation) {
  const Posture posture = orthoglide_at(0.1, -0.05, 0.08);
  Vector6 displacement;
  displacement << 4e-4, -3e-4, 5e-4, 2e-3, -1e-3, 1.5e-3;
  expect_tangent_is_the_slope(orthoglide().manipulator, posture,
                              spatial::displaced(posture.platform, displacement), 1e-5, 1e-4);
}

TEST(Equilibrium, TangentStiffnessIsTheSlopeForAnArmFarFromItsPosture) {
  const Manipulator manipulator = arm(5);
  const Posture posture = arm_posture(manipulator);
  Vector6 displacement;
  displacement << 0.03, -0.02, 0.04, 0.1, -0.2, 0.15;
  expect_tangent_is_the_slope(manipulator, posture,
                              spatial::displaced(posture.platform, displacement), 1e-4, 1e-4);
}

TEST(Equilibrium, ComplianceUnderALoadIsTheSlopeOfTheDisplacement) {
  const Manipulator manipulator = arm(6);
  const Posture posture = arm_posture(manipulator);
  const Load load{{120, -80, -150}, {4, -6, 5}, {0.02, 0.05, -0.03}};
  const Equilibrium e = equilibrium_under_load(manipulator, posture, load);
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  EXPECT_GT(e.displacement.translation.norm(), 0.01);  // the load is not a small one
  // A load at the reference point: the offset point adds its own geometric stiffness.
  Load plain = load;
  plain.moment = e.wrench.moment;
  plain.point_on_platform.setZero();
  for (int j = 0; j < 3; ++j) {
    const double h = 1e-2;
    Load more = plain, less = plain;
    more.force[j] += h;
    less.force[j] -= h;
    const Vector6 numerical =
        spatial::pose_difference(equilibrium_under_load(manipulator, posture, less).platform,
                                 equilibrium_under_load(manipulator, posture, more).platform) /
        (2 * h);
    const Vector6 tangent = e.compliance->matrix().col(j);
    EXPECT_LT((numerical - tangent).norm(), 1e-6 * tangent.norm());
  }
}

TEST(Equilibrium, WorkAroundAClosedPathIsZero) {
  // Pure translations: the moments then do no work and the elastic energy alone must balance.
  const Posture posture = orthoglide_at(0.12635, 0.12635, -0.07365);
  const int steps = 64;
  double work = 0, highest = 0;
  for (int i = 0; i < steps; ++i) {
    const double s = 2 * M_PI * i / steps;
    Vector6 displacement = Vector6::Zero();
    displacement.head<3>() = 5e-4 * Vector3(std::cos(s) - 1, std::sin(s), 0.5 * std::sin(2 * s));
    const Vector3 velocity = 5e-4 * Vector3(-std::sin(s), std::cos(s), std::cos(2 * s));
    const Equilibrium e = equilibrium_at_pose(orthoglide().manipulator, posture,
                                              spatial::displaced(posture.platform, displacement));
    // The trapezoidal rule converges faster than any power on a smooth closed path.
    work += e.wrench.force.dot(velocity) * 2 * M_PI / steps;
    highest = std::max(highest, e.energy);
  }
  EXPECT_LT(std::abs(work), 1e-8 * highest);
}

TEST(Equilibrium, WorkDoneIsTheEnergyStored) {
  const Manipulator manipulator = arm(7);
  const Posture posture = arm_posture(manipulator);
  const Load load{{60, -40, -90}, Vector3::Zero(), {0.05, 0, 0.02}};
  // Integral of f(s) . dr(s) along the loading path by Gauss-Legendre over shares of the load.
  const double nodes[] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                          0.9061798459386640};
  const double weights[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                            0.4786286704993665, 0.2369268850561891};
  double work = 0;
  const int intervals = 8;
  const auto point_at = [&](double share) {
    const Equilibrium e = equilibrium_under_load(manipulator, posture, load.scaled(share));
    return Vector3(e.platform * load.point_on_platform);
  };
  for (int i = 0; i < intervals; ++i)
    for (int g = 0; g < 5; ++g) {
      const double s = (i + 0.5 * (1 + nodes[g])) / intervals, h = 1e-3;
      const Vector3 slope =
          (8 * (point_at(s + h) - point_at(s - h)) - (point_at(s + 2 * h) - point_at(s - 2 * h))) /
          (12 * h);
      work += 0.5 * weights[g] / intervals * (s * load.force).dot(slope);
    }
  const double energy = equilibrium_under_load(manipulator, posture, load).energy;
  EXPECT_NEAR(work, energy, 1e-8 * energy);
}

TEST(Equilibrium, SmallLoadsGiveTheUnloadedCompliance) {
  const Posture posture = orthoglide_at(-0.05, 0.03, 0.06);
  const UnloadedStiffness unloaded = unloaded_stiffness(orthoglide().manipulator, posture);
  const Load load{{1e-3, -2e-3, 1.5e-3}, {1e-4, 2e-4, -1e-4}, Vector3::Zero()};
  const Equilibrium e = equilibrium_under_load(orthoglide().manipulator, posture, load);
  Vector6 wrench;
  wrench << load.force, load.moment;
  const Vector6 linear = unloaded.compliance->matrix() * wrench;
  EXPECT_LT((e.displacement.coordinates() - linear).norm(), 1e-5 * linear.norm());
  EXPECT_LT((e.stiffness->matrix() - unloaded.stiffness->matrix()).norm(),
            1e-5 * unloaded.stiffness->matrix().norm());
}

TEST(Equilibrium, ALoadAtAPlatformPointIsALoadAtAMovedReferencePoint) {
  const Manipulator manipulator = arm(8);
  const Posture posture = arm_posture(manipulator);
  const Vector3 point(0.1, -0.05, 0.08);
  const Load at_point{{50, 80, -60}, {2, 1, -3}, point};
  const Equilibrium a = equilibrium_under_load(manipulator, posture, at_point);

  const Manipulator moved = manipulator.with_reference_point(point);
  Posture moved_posture = posture;
  moved_posture.platform = posture.platform * Pose::translation(point);
  const Load at_reference{at_point.force, at_point.moment, Vector3::Zero()};
  const Equilibrium b = equilibrium_under_load(moved, moved_posture, at_reference);

  EXPECT_LT((a.platform * point - b.platform.position()).norm(), 1e-11);
  EXPECT_NEAR(a.energy, b.energy, 1e-10 * a.energy);
  EXPECT_EQ(a.free.unstable, b.free.unstable);
}

TEST(Equilibrium, DoesNotDependOnTheBaseFrame) {
  samples::RandomChains random(9);
  const spatial::Compliance6 soft = random.compliance();
  const Pose moved = random.pose(1.5);
  const auto solve = [&](const Pose& base) {
    ChainBuilder chain("c", base);
    chain.actuator("q", Motion::rz, 1e4).link("l", Pose::translation({0.4, 0, 0}), soft);
    const Manipulator m("m", {chain.build()});
    const Posture posture = posture_from_joints(m, {{"q", 0.5}}).posture;
    const Load load{
        base.rotation() * Vector3(30, -50, 20), base.rotation() * Vector3(1, 2, -1), {0.05, 0, 0}};
    return equilibrium_under_load(m, posture, load);
  };
  const Equilibrium here = solve(Pose()), there = solve(moved);
  EXPECT_LT(spatial::pose_difference(moved * here.platform, there.platform).norm(), 1e-11);
  EXPECT_NEAR(here.energy, there.energy, 1e-11 * here.energy);
}

TEST(Equilibrium, NewtonConvergesQuadratically) {
  const Posture posture = orthoglide_at(0.12635, 0.12635, 0.12635);
  const Vector6 shift{5e-4, 5e-4, 5e-4, 0, 0, 0};
  const Equilibrium e = equilibrium_at_pose(orthoglide().manipulator, posture,
                                            spatial::displaced(posture.platform, shift));
  ASSERT_GE(e.corrections.size(), 3u);
  ASSERT_LE(e.corrections.size(), 6u);
  // c_{k+1} <= C c_k^2 with one constant for the whole history.
  for (std::size_t k = 0; k + 1 < e.corrections.size(); ++k)
    EXPECT_LE(e.corrections[k + 1], 20 * e.corrections[k] * e.corrections[k] + 1e-13);
}

TEST(Equilibrium, ExtraPassiveJointsThatRepeatALegsSpinChangeNothing) {
  // Legs with a spherical joint at both ends can spin: a redundant coordinate.
  const auto stewart = [](bool spin) {
    std::vector<Chain> legs;
    for (int i = 0; i < 6; ++i) {
      const double b = M_PI / 180 * (i % 2 == 0 ? 60 * i - 10 : 60 * i - 50);
      const double p = M_PI / 180 * (i % 2 == 0 ? 60 * i - 50 + 60 : 60 * i - 10 - 60);
      ChainBuilder leg("leg" + std::to_string(i),
                       Pose::translation(0.5 * Vector3(std::cos(b), std::sin(b), 0)));
      leg.passive("bx", Motion::rx).passive("by", Motion::ry);
      if (spin) leg.passive("bz", Motion::rz);
      leg.actuator("l", Motion::tz, 1e7, 0.6);
      leg.passive("px", Motion::rx).passive("py", Motion::ry).passive("pz", Motion::rz);
      leg.offset(Pose::translation(-0.25 * Vector3(std::cos(p), std::sin(p), 0)));
      legs.push_back(leg.build());
    }
    return Manipulator("stewart", legs);
  };
  const Load load{{500, -300, -2000}, {40, 30, -20}, {0, 0, 0.1}};
  const auto solve = [&](const Manipulator& m) {
    const PostureResult posture = posture_at(m, Pose::translation({0.02, 0.01, 0.55}));
    EXPECT_TRUE(posture.reached) << posture.reason;
    return equilibrium_under_load(m, posture.posture, load);
  };
  const Equilibrium plain = solve(stewart(false)), spinning = solve(stewart(true));
  ASSERT_EQ(plain.status, EquilibriumStatus::converged) << plain.reason;
  ASSERT_EQ(spinning.status, EquilibriumStatus::converged) << spinning.reason;
  EXPECT_LT(spatial::pose_difference(plain.platform, spinning.platform).norm(), 1e-11);
  EXPECT_EQ(spinning.held.neutral, 6);
  EXPECT_TRUE(spinning.free.stable());
}

// Hexapods in general postures; with `spin`, every leg has a spherical joint at both ends and may
// turn about its own axis, which changes nothing else.
Manipulator hexapod(unsigned seed, bool spin) {
  samples::RandomChains random(seed);
  std::vector<Chain> legs;
  for (int i = 0; i < 6; ++i) {
    const double a = random.uniform(0, 2 * M_PI), b = random.uniform(0, 2 * M_PI);
    const Vector3 foot(0.5 * std::cos(a), 0.5 * std::sin(a), random.uniform(-0.05, 0.05));
    const Vector3 top(0.3 * std::cos(b), 0.3 * std::sin(b), random.uniform(-0.05, 0.05));
    const Vector3 axis = Vector3(0.02, -0.03, 0.65) + top - foot;
    const double length = axis.norm();
    const double ry = std::atan2(axis.x(), axis.z()), rx = -std::asin(axis.y() / length);
    ChainBuilder leg("leg" + std::to_string(i), Pose::translation(foot));
    leg.passive("lower.Ry", Motion::ry, ry).passive("lower.Rx", Motion::rx, rx);
    if (spin) leg.passive("lower.Rz", Motion::rz);
    leg.actuator("length", Motion::tz, random.uniform(1e7, 3e7), length / 2);
    leg.link("rod", Pose::translation({0, 0, length / 2}), random.compliance());
    leg.passive("upper.Rz", Motion::rz);
    leg.passive("upper.Rx", Motion::rx, -rx).passive("upper.Ry", Motion::ry, -ry);
    leg.offset(Pose::translation(-top));
    legs.push_back(leg.build());
  }
  return Manipulator("hexapod", legs);
}

Equilibrium hexapod_under(const Manipulator& hexapod, const Load& load) {
  const PostureResult posture = posture_at(hexapod, Pose::translation({0.02, -0.03, 0.65}));
  EXPECT_TRUE(posture.reached) << posture.reason;
  return equilibrium_under_load(hexapod, posture.posture, load);
}

TEST(Equilibrium, LegsThatSpinBetweenSphericalJointsCarryAsThoseThatDoNot) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    samples::RandomChains random(1000 + seed);
    const Vector3 force = random.vector(1), moment = random.vector(0.1);
    for (const double size : {1e1, 1e3, 3e4}) {
      const Load load{.force = size * force, .moment = size * moment};
      const Equilibrium plain = hexapod_under(hexapod(seed, false), load);
      const Equilibrium spinning = hexapod_under(hexapod(seed, true), load);
      if (plain.status != EquilibriumStatus::converged) continue;  // beyond what the legs carry
      ++compared;
      ASSERT_EQ(spinning.status, EquilibriumStatus::converged) << seed << " " << size;
      EXPECT_LT(spatial::pose_difference(plain.platform, spinning.platform).norm(), 1e-10)
          << seed << " " << size;
      EXPECT_EQ(plain.free.unstable, spinning.free.unstable) << seed << " " << size;
      EXPECT_EQ(spinning.free.neutral, 6) << seed << " " << size;
    }
  }
  EXPECT_GE(compared, 75);
}

TEST(Equilibrium, SaysThatNothingResistsALoadOnAFreeMotion) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/stewart_gough_a.yaml");
  const PostureResult posture = posture_at(robot.manipulator, Pose::translation({0, 0, 0.6}));
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture.posture,
                                               {Vector3::Zero(), {0, 0, 10}, Vector3::Zero()});
  EXPECT_EQ(e.status, EquilibriumStatus::unsupported);
  EXPECT_EQ(e.reached, 0);
  EXPECT_FALSE(e.reason.empty());
  EXPECT_TRUE(e.platform.position().isApprox(posture.posture.platform.position()));
}

TEST(Equilibrium, SaysThatARigidRobotCannotFollow) {
  ChainBuilder chain("slide");
  chain.actuator("z", Motion::tz, 1e6);
  const Manipulator slide("slide", {chain.build()});
  const Posture posture = posture_from_joints(slide, {}).posture;
  const Equilibrium sideways = equilibrium_at_pose(slide, posture, Pose::translation({1e-3, 0, 0}));
  EXPECT_EQ(sideways.status, EquilibriumStatus::rigid);
  const Equilibrium along = equilibrium_under_load(slide, posture, {{50, 0, 200}});
  ASSERT_EQ(along.status, EquilibriumStatus::converged) << along.reason;
  EXPECT_NEAR(along.displacement.translation.z(), 200 / 1e6, 1e-15);
  EXPECT_NEAR(along.wrench.force.x(), 50, 1e-9);  // carried by the rigid guide
  EXPECT_FALSE(along.stiffness);
}

TEST(Equilibrium, PreloadedPassiveSpringsMoveTheUnloadedRobot) {
  // Two springs in series: a joint spring relaxed at 10 deg against an actuator spring.
  ChainBuilder chain("c");
  chain.actuator("q", Motion::rz, 100.0).passive("p", Motion::rz, 50.0, 0.1, 0.0);
  const Manipulator m("m", {chain.build()});
  const Posture posture = posture_from_joints(m, {}).posture;
  const Equilibrium free = equilibrium_under_load(m, posture, {});
  ASSERT_EQ(free.status, EquilibriumStatus::converged);
  EXPECT_NEAR(free.displacement.rotation.z(), 0.1, 1e-12);
  EXPECT_NEAR(free.energy, 0, 1e-20);
}

// A slide with play between two stops, then a spring in every other direction.
Chain slide_with_play(const std::string& name, double lower, double upper, double contact) {
  ChainBuilder chain(name);
  chain.passive("slide", Motion::tx).law("slide", std::make_shared<StopLaw>(lower, upper, contact));
  for (const Motion motion : {Motion::ty, Motion::tz, Motion::rx, Motion::ry, Motion::rz})
    chain.actuator(to_string(motion), motion, 1e5);
  return chain.build();
}

// However stiff the stop is beside the other springs.
class StiffStop : public ::testing::TestWithParam<double> {};

TEST_P(StiffStop, CarriesTheLoadThatTakesTheJointThere) {
  const double contact = GetParam();
  const Manipulator play("play", {slide_with_play("slide", -1e-3, 2e-3, contact)});
  const Posture inside = posture_at(play, Pose()).posture;
  for (const double force : {0.5, -300.0, 4000.0}) {
    const Equilibrium e = equilibrium_under_load(play, inside, {.force = {force, 70, 0}});
    ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    const double stop = force > 0 ? 2e-3 : -1e-3;
    EXPECT_NEAR(e.displacement.translation.x(), stop + force / contact, 1e-12);
    EXPECT_NEAR(e.displacement.translation.y(), 70 / 1e5, 1e-12);
    EXPECT_TRUE(e.free.stable());
  }
  // A load that works in the gap alone has nothing to hold it, unless it has no share there.
  EXPECT_EQ(equilibrium_under_load(play, inside, {.force = {0, 70, 0}}).status,
            EquilibriumStatus::converged);
}

// One slide may not go above 0, the other not below 10 mm: the stops share what they lack.
TEST_P(StiffStop, ContradictoryOnesPressAgainstEachOther) {
  const double contact = GetParam(), infinity = std::numeric_limits<double>::infinity();
  const Manipulator pair("pair", {slide_with_play("low", -infinity, 0, contact),
                                  slide_with_play("high", 0.010, infinity, contact)});
  const PostureResult middle = posture_at(pair, Pose::translation({0.005, 0, 0}));
  ASSERT_TRUE(middle.reached);
  const Equilibrium e = equilibrium_under_load(pair, middle.posture, {.force = {0, 70, 0}});
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  EXPECT_NEAR(e.chains[0].wrench.force.x(), 0.005 * contact, 1e-9 * contact);
  EXPECT_NEAR(e.chains[1].wrench.force.x(), -0.005 * contact, 1e-9 * contact);
  EXPECT_NEAR(e.displacement.translation.x(), 0, 1e-12);
  EXPECT_NEAR(e.displacement.translation.y(), 70 / 2e5, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Contacts, StiffStop, ::testing::Values(1e5, 1e8, 1e11));

}  // namespace
}  // namespace kinetostat::vjm::equilibrium_test
