// Inner bodies, gravity, loads at nodes, stops, geometric errors, patterns: what goes beyond a
// parallel robot without weight.
#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/chain/beam.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/assembly.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/random_chain.h"
#include "vjm/robot_text.h"

namespace kinetostat::vjm::mechanism_test {
namespace {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

const std::string robots = std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/";

std::string replaced_all(std::string text, const std::string& from, const std::string& to) {
  std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  for (; at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

Posture posture_of(const Manipulator& manipulator, const Vector3& point) {
  const PostureResult result = posture_at(manipulator, Pose::translation(point));
  EXPECT_TRUE(result.reached) << result.reason;
  return result.posture;
}

struct PrparRow {
  double coordinate, translation, translation_coupling, rotation, rotation_coupling;
};

// JAMRIS09 Table 2, unloaded; the effective beams meet it within 2 %.
TEST(Mechanism, ParallelogramLegsMeetThePublishedTable) {
  const Robot robot = read_robot(robots + "orthoglide_prpar.yaml");
  const PrparRow rows[] = {{0, 2.78, 0, 1.94, 0},
                           {-0.07365, 9.86, 5.80, 2.06, -0.32},
                           {0.12635, 21.2, -10.2, 2.65, 1.14}};
  for (const PrparRow& row : rows) {
    const double p = row.coordinate;
    const UnloadedStiffness result =
        unloaded_stiffness(robot.manipulator, posture_of(robot.manipulator, {p, p, p}));
    const Matrix6 c = result.compliance.value().matrix();
    EXPECT_NEAR(c(0, 0) / 1e-7, row.translation, 0.02 * row.translation);
    EXPECT_NEAR(c(0, 1) / 1e-7, row.translation_coupling, 0.02 * row.translation);
    EXPECT_NEAR(c(3, 3) / 1e-4, row.rotation, 0.02 * row.rotation);
    EXPECT_NEAR(c(3, 4) / 1e-4, row.rotation_coupling, 0.02 * row.rotation);
  }
}

TEST(Mechanism, TangentIsTheSlopeWithInnerBodiesThatMove) {
  const Robot robot = read_robot(robots + "orthoglide_prpar.yaml");
  const Posture posture = posture_of(robot.manipulator, {0.05, -0.04, 0.08});
  Vector6 displacement;
  displacement << 4e-4, -3e-4, 5e-4, 4e-4, -3e-4, 2e-4;
  const Pose loaded = spatial::displaced(posture.platform, displacement);
  const auto wrench = [&](const Pose& pose) {
    const Equilibrium e = equilibrium_at_pose(robot.manipulator, posture, pose);
    EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    return e.wrench.coordinates();
  };
  Vector6 size = Vector6::Zero();
  const Equilibrium e = equilibrium_at_pose(robot.manipulator, posture, loaded);
  // The end chains are rigid: the compliance is what exists.
  const Matrix6 compliance = e.compliance.value().matrix();
  for (int j = 0; j < 6; ++j) {
    const Vector6 step = (j < 3 ? 1e-6 : 1e-5) * Vector6::Unit(j);
    const Vector6 change =
        wrench(spatial::displaced(loaded, step)) - wrench(spatial::displaced(loaded, -step));
    size = compliance * change - 2 * step;
    EXPECT_LT(size.head<3>().norm(), 1e-5 * step.norm()) << j;
    EXPECT_LT(size.tail<3>().norm(), 1e-5 * step.norm() * (j < 3 ? 10 : 1)) << j;
  }
}

// A chain may be cut anywhere into two that meet in an inner body.
TEST(Mechanism, ACutChainIsTheSameChain) {
  samples::RandomChains random(51);
  const spatial::Compliance6 soft1 = random.compliance(), soft2 = random.compliance();
  const Pose first(random.pose(0.3)), second(random.pose(0.3)), base(random.pose(0.5));
  ChainBuilder whole("whole", base);
  whole.actuator("a", Motion::ry, 2e4, 0.3).link("l1", first, soft1);
  whole.actuator("b", Motion::rz, 1e4, -0.5).link("l2", second, soft2);
  ChainBuilder near("near", base), far("far");
  near.actuator("a", Motion::ry, 2e4, 0.3).link("l1", first, soft1);
  far.actuator("b", Motion::rz, 1e4, -0.5).link("l2", second, soft2);
  const Manipulator one("one", {whole.build()});
  const Manipulator two("two", {near.build(), far.build()}, {{Span::base, 1}, {1, Span::platform}},
                        {"middle"});

  const Load load{{300, -500, 400}, {30, 20, -40}, {0.02, 0.01, 0.03}};
  const Equilibrium a = equilibrium_under_load(one, posture_from_joints(one, {}).posture, load);
  const Equilibrium b = equilibrium_under_load(two, posture_from_joints(two, {}).posture, load);
  ASSERT_EQ(a.status, EquilibriumStatus::converged) << a.reason;
  ASSERT_EQ(b.status, EquilibriumStatus::converged) << b.reason;
  EXPECT_GT(a.displacement.translation.norm(), 1e-3);
  EXPECT_LT(spatial::pose_difference(a.platform, b.platform).norm(), 1e-10);
  EXPECT_NEAR(a.energy, b.energy, 1e-9 * a.energy);
  EXPECT_LT((a.stiffness->matrix() - b.stiffness->matrix()).norm(),
            1e-8 * a.stiffness->matrix().norm());
  EXPECT_EQ(a.free.unstable, b.free.unstable);
}

TEST(Gravity, ACantileverSagsLikeABeamUnderItsOwnWeight) {
  const Robot robot = robot_from(R"(kinetostat: 1
name: beam
units: {length: mm, force: N, angle: deg}
gravity: {direction: [0, 0, -1], acceleration: 10 m/s^2}
materials: {steel: {E: 210 GPa, nu: 0.3, density: 8000 kg/m^3}}
links:
  beam: {beam: {length: 1000, section: {rectangle: {y: 20, z: 10}}, material: steel, theory: euler-bernoulli}}
chain_types: {arm: [{link: beam}]}
manipulator: {chain: arm}
)");
  const double ei = 210e9 * 0.02 * 1e-6 / 12, q = 8000 * 0.02 * 0.01 * 10;
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  // A tenth of gravity keeps it linear to the accuracy of the comparison.
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, {.gravity = 1e-4});
  EXPECT_NEAR(e.displacement.translation.z(), -1e-4 * q / (8 * ei), 1e-6 * 1e-4 * q / (8 * ei));
  EXPECT_NEAR(e.displacement.rotation.y(), 1e-4 * q / (6 * ei), 1e-6 * 1e-4 * q / (6 * ei));
}

TEST(Gravity, SegmentsCarryTheWeightOfTheWholeBeam) {
  const auto sag = [](int segments) {
    const Robot robot = robot_from(R"(kinetostat: 1
name: beam
units: {length: mm, force: N, angle: deg}
gravity: {direction: [0, 0, -1]}
materials: {steel: {E: 210 GPa, nu: 0.3, density: 8000 kg/m^3}}
links:
  beam: {beam: {length: 500, section: {circle: {diameter: 20}}, material: steel, segments: )" +
                                   std::to_string(segments) + R"(}}
chain_types: {arm: [{link: beam}]}
manipulator: {chain: arm}
)");
    const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
    return equilibrium_under_load(robot.manipulator, posture, {.gravity = 1e-3})
        .displacement.translation.z();
  };
  // Bending is exact for any number; shear under a distributed load is not lumped exactly.
  EXPECT_NEAR(sag(4), sag(1), 2e-3 * std::abs(sag(1)));
}

TEST(NodeLoads, ALoadAtTheLastNodeIsALoadOnThePlatform) {
  samples::RandomChains random(52);
  ChainBuilder chain("c");
  chain.actuator("q", Motion::rz, 1e4)
      .link("l", Pose::translation({0.4, 0.1, 0}), random.compliance());
  chain.node("tip", {0.1, 0.02, -0.05});
  const Manipulator m("m", {chain.build()});
  const Posture posture = posture_from_joints(m, {}).posture;
  const Vector3 force(40, -30, 60), moment(1, 2, -3);
  const Equilibrium on_platform =
      equilibrium_under_load(m, posture, {force, moment, {0.1, 0.02, -0.05}});
  const Equilibrium on_node = equilibrium_under_load(
      m, posture, {.nodes = {{0, chain.so_far().node_index("tip"), force, moment}}});
  EXPECT_LT(spatial::pose_difference(on_platform.platform, on_node.platform).norm(), 1e-11);
}

// The virtual work of torques J'w in the joints is that of the wrench w at the end.
TEST(JointLoads, DoTheWorkOfAWrenchThroughTheJacobian) {
  samples::RandomChains random(53);
  ChainBuilder builder("c");
  builder.actuator("q1", Motion::rz, 2e4, 0.3).offset(random.pose(0.4));
  builder.actuator("q2", Motion::ry, 1e4, -0.7).offset(random.pose(0.4));
  builder.actuator("d", Motion::tx, 3e5, 0.1).offset(random.pose(0.2));
  const Manipulator m("m", {builder.build()});
  const Posture posture = posture_from_joints(m, {}).posture;
  const Load wrench{.force = {200, -150, 300}, .moment = {20, -10, 15}};
  const Equilibrium pushed = equilibrium_under_load(m, posture, wrench);
  ASSERT_EQ(pushed.status, EquilibriumStatus::converged) << pushed.reason;
  ChainKinematics there;
  evaluate(m.chains()[0], pushed.chains[0].coordinates, there);
  const Eigen::VectorXd torques =
      there.jacobian.transpose() * wrench.at_reference_point(pushed.platform);
  Load driven;
  for (Eigen::Index k = 0; k < 3; ++k)
    driven.joints.push_back({.chain = 0, .coordinate = k, .force = torques[k]});
  const Equilibrium turned = equilibrium_under_load(m, posture, driven);
  ASSERT_EQ(turned.status, EquilibriumStatus::converged) << turned.reason;
  EXPECT_LT(spatial::pose_difference(pushed.platform, turned.platform).norm(), 1e-12);
  EXPECT_GT(spatial::pose_difference(posture.platform, turned.platform).norm(), 1e-3);
}

// A torque t on a spring k is a command that stands t/k further, in a robot of legs as well.
TEST(JointLoads, AreCommandsFurtherByTheDeflectionOfTheSpring) {
  const Robot robot = read_robot(robots + "orthoglide.yaml");
  const Posture posture = posture_of(robot.manipulator, {0.02, -0.03, 0.01});
  const Chain& chain = robot.manipulator.chains()[1];
  const auto springs = chain.springs();
  const auto drive = std::find_if(springs.begin(), springs.end(), [&](const Spring& spring) {
    return chain.coordinates()[static_cast<std::size_t>(spring.first)].role == Role::actuated;
  });
  ASSERT_NE(drive, springs.end());
  const double force = 250, shift = force / drive->stiffness(0, 0);
  Posture further = posture;
  further.coordinates[1][drive->first] += shift;
  const Load load{.force = {30, -20, 40}};
  Load driven = load;
  driven.joints = {{.chain = 1, .coordinate = drive->first, .force = force}};
  const Equilibrium by_load = equilibrium_under_load(robot.manipulator, posture, driven);
  const Equilibrium by_command = equilibrium_under_load(robot.manipulator, further, load);
  ASSERT_EQ(by_load.status, EquilibriumStatus::converged) << by_load.reason;
  ASSERT_EQ(by_command.status, EquilibriumStatus::converged) << by_command.reason;
  EXPECT_LT(spatial::pose_difference(by_load.platform, by_command.platform).norm(), 1e-11);
  EXPECT_GT(spatial::pose_difference(by_load.platform, posture.platform).norm(), 1e-5);
}

TEST(Stops, HoldAJointThatLeansOnThem) {
  ChainBuilder chain("c");
  chain.passive("p", Motion::rz, 10.0, 0.0, 0.0);
  chain.law("p", std::make_shared<StopLaw>(-0.1, 0.2, 1000.0));
  const Manipulator m("m", {chain.build()});
  const Posture posture = posture_from_joints(m, {}).posture;
  const auto turned = [&](double moment) {
    const Equilibrium e = equilibrium_under_load(m, posture, {.moment = {0, 0, moment}});
    EXPECT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
    return e.displacement.rotation.z();
  };
  EXPECT_NEAR(turned(1.5), 0.15, 1e-12);
  EXPECT_NEAR(turned(5), (5 + 0.2 * 1000) / 1010, 1e-12);
  EXPECT_NEAR(turned(-5), -(5 + 0.1 * 1000) / 1010, 1e-12);
  EXPECT_THROW(StopLaw(0.2, 0.1, 1e3), std::invalid_argument);
}

struct ShiftRow {
  Vector3 point, shift;  // [mm]
};

// NONPERF Table 1, case A: every actuator 1 mm off; no internal loads arise.
TEST(GeometricErrors, ActuatorErrorsShiftTheOrthoglideAsPublished) {
  const std::string nominal = io::read_text(robots + "orthoglide.yaml");
  const auto with_error = [&](const std::string& millimetres) {
    return robot_from(
        replaced_all(nominal, "type: puu, base:",
                     "type: puu, errors: [{at: rho, point: [" + millimetres + ", 0, 0]}], base:"));
  };
  const ShiftRow rows[] = {{{0, 0, 0}, {1, 1, 1}},
                           {{126.35, 126.35, 126.35}, {0.501, 0.501, 0.501}},
                           {{-73.65, -73.65, -73.65}, {2.018, 2.018, 2.018}},
                           {{126.35, 126.35, -73.65}, {0.733, 0.733, 0.268}},
                           {{-73.65, -73.65, 126.35}, {0.558, 0.558, 1.281}}};
  const Robot tiny = with_error("0.001"), whole = with_error("1");
  for (const ShiftRow& row : rows) {
    const Posture posture = posture_of(tiny.manipulator, 1e-3 * row.point);
    const Equilibrium linear = equilibrium_under_load(tiny.manipulator, posture, {});
    ASSERT_EQ(linear.status, EquilibriumStatus::converged) << linear.reason;
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(linear.displacement.translation[i] / 1e-6, row.shift[i], 2e-3);
    for (const ChainEquilibrium& chain : linear.chains) EXPECT_LT(chain.wrench.force.norm(), 1e-6);
  }
  const Posture q2 = posture_of(whole.manipulator, {-0.07365, -0.07365, -0.07365});
  const Equilibrium e = equilibrium_under_load(whole.manipulator, q2, {});
  EXPECT_NEAR(e.displacement.translation.x() * 1e3, 1.987, 6e-4);
}

TEST(GeometricErrors, ATwistedChainOfAnOverconstrainedRobotLoadsTheOthers) {
  const std::string nominal = io::read_text(robots + "orthoglide_prpar.yaml");
  const Robot robot = robot_from(
      replaced_all(nominal, "{name: x, type: carriage,",
                   "{name: x, type: carriage, errors: [{at: rho, rotation_vector: [1, 0, 0]}],"));
  const Posture posture = posture_of(robot.manipulator, {0.05, 0.05, 0.05});
  const Equilibrium e = equilibrium_under_load(robot.manipulator, posture, {});
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  Vector6 sum = Vector6::Zero();
  double largest = 0;
  for (std::size_t c = 0; c < e.chains.size(); ++c) {
    if (robot.manipulator.span(c).to != Span::platform) continue;
    sum += e.chains[c].wrench.coordinates();
    largest = std::max(largest, e.chains[c].wrench.coordinates().norm());
  }
  EXPECT_GT(largest, 0.1);                // internal wrenches
  EXPECT_LT(sum.norm(), 1e-9 * largest);  // that balance
  EXPECT_GT(e.energy, 0);
}

// The linear solution is the limit of the full one: their difference falls with the square.
TEST(GeometricErrors, TheLinearAssemblyIsTheLimitOfTheFullOne) {
  const std::string twisted = io::read_text(robots + "orthoglide_errors.yaml");
  const auto difference = [&](const std::string& degrees) {
    const Robot robot = robot_from(replaced_all(twisted, "rotation_vector: [1, 0, 0]",
                                                "rotation_vector: [" + degrees + ", 0, 0]"));
    const Assembly a =
        assemble(robot.manipulator, posture_of(robot.manipulator, {0.03, -0.02, 0.05}));
    EXPECT_EQ(a.assembled.status, EquilibriumStatus::converged) << a.assembled.reason;
    return (a.linear_shift.coordinates() - a.assembled.displacement.coordinates()).norm();
  };
  const double coarse = difference("0.4"), fine = difference("0.1");
  EXPECT_NEAR(coarse / fine, 16, 3);
}

TEST(Patterns, ThreeTurnedCopiesAreTheOrthoglide) {
  const Robot explicit_robot = read_robot(robots + "orthoglide.yaml");
  const std::string text = io::read_text(robots + "orthoglide.yaml");
  const Robot pattern = robot_from(
      text.substr(0, text.find("manipulator:")) +
      "manipulator:\n  chains:\n    - {name: leg, type: puu, base: [0, -109.53084041, 0], pattern: "
      "{count: 3, axis: [1, 1, 1]}}\n");
  EXPECT_EQ(pattern.manipulator.chains()[1].name(), "leg2");
  const Vector3 point(0.03, -0.02, 0.07);
  const auto stiffness = [&](const Robot& robot) {
    return unloaded_stiffness(robot.manipulator, posture_of(robot.manipulator, point))
        .stiffness->matrix();
  };
  const Matrix6 a = stiffness(explicit_robot), b = stiffness(pattern);
  EXPECT_LT((a - b).norm(), 1e-9 * a.norm());
}

}  // namespace
}  // namespace kinetostat::vjm::mechanism_test
