// Equilibria of many postures together against each alone.
#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/vjm/batches/batches.h"
#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/statics/equilibrium.h"

#include "vjm/batches/poses_about.h"
#include "vjm/random_chain.h"

namespace kinetostat::vjm::equilibria_test {
namespace {

using samples::poses_about;
using samples::RandomChains;
using samples::shipped;
using spatial::Pose;
using spatial::Vector3;

// Each with its own load, as large as this force [N] about.
std::vector<Load> loads_of(std::size_t count, double force) {
  RandomChains random(5);
  std::vector<Load> loads(count);
  for (Load& load : loads) {
    load.force = random.vector(force);
    load.moment = random.vector(0.1 * force);
    load.point_on_platform = random.vector(0.05);
  }
  return loads;
}

double size_of(const Manipulator& manipulator, const Posture& posture) {
  ChainKinematics kinematics;
  evaluate(manipulator.chains()[0], posture.coordinates_of(manipulator.chains()[0], 0), kinematics);
  return kinematics.reach;
}

// What is found is what is found alone; how many there are.
int expect_as_alone(const Manipulator& manipulator, const std::vector<Posture>& postures,
                    const std::vector<Load>& loads) {
  const auto together = stable_equilibria(manipulator, postures, loads);
  EXPECT_EQ(together.size(), postures.size());
  int found = 0;
  for (std::size_t i = 0; i < postures.size(); ++i) {
    if (!together[i]) continue;
    ++found;
    const Equilibrium alone = equilibrium_under_load(manipulator, postures[i], loads[i]);
    EXPECT_EQ(alone.status, EquilibriumStatus::converged) << i;
    EXPECT_TRUE(alone.free.stable()) << i;
    const double length = size_of(manipulator, postures[i]);
    const auto apart = spatial::pose_difference(alone.platform, together[i]->platform);
    EXPECT_LT(apart.head<3>().norm() + length * apart.tail<3>().norm(), 1e-12 * length) << i;
    EXPECT_LT((together[i]->stiffness.matrix() - alone.stiffness->matrix()).norm(),
              1e-10 * alone.stiffness->matrix().norm())
        << i;
    EXPECT_LT((together[i]->stiffness.frame().point - alone.platform.position()).norm(),
              1e-12 * length);
  }
  return found;
}

std::vector<Posture> reached_of(const Manipulator& manipulator, const std::vector<Pose>& poses) {
  std::vector<Posture> reached;
  for (const PostureResult& result : postures_at(manipulator, poses))
    if (result.reached) reached.push_back(result.posture);
  return reached;
}

struct Shipped {
  const char* file;
  double spread;  // [m]
  double turn;    // [rad], where the platform turns at all
  double force;   // [N]
};
class LoadedRobot : public testing::TestWithParam<Shipped> {};

TEST_P(LoadedRobot, ManyEquilibriaAsEachAlone) {
  const auto [file, spread, turn, force] = GetParam();
  const Manipulator robot = shipped(file).manipulator;
  const std::vector<Posture> postures = reached_of(robot, poses_about(robot, spread, turn, 30));
  ASSERT_GT(postures.size(), 15u);
  const int found = expect_as_alone(robot, postures, loads_of(postures.size(), force));
  EXPECT_GT(found, static_cast<int>(postures.size()) * 3 / 4);
}

INSTANTIATE_TEST_SUITE_P(Robots, LoadedRobot,
                         testing::Values(Shipped{"orthoglide.yaml", 0.05, 0, 200},

                                         Shipped{"gantry.yaml", 0.05, 0, 500},

                                         Shipped{"six_axis.yaml", 0.05, 0.3, 500},

                                         Shipped{"translational_3puu.yaml", 0.02, 0, 50}),
                         [](const auto& one) {
                           const std::string file = one.param.file;
                           return file.substr(0, file.find('.'));
                         });

// Chains whose ends are one platform, with drives, links, passive joints, some coupled, masses and
// errors of their geometry and drives.
Manipulator random_robot(unsigned seed, unsigned chain_count, int passive) {
  RandomChains random(seed);
  std::vector<Chain> chains;
  for (unsigned c = 0; c < chain_count; ++c) {
    const Chain bare = random.chain(passive, true);
    ChainKinematics kinematics;
    evaluate(bare, bare.home(), kinematics);
    ChainBuilder builder(bare);
    builder.offset(kinematics.end.inverse());
    builder.mass("mass", 3.0, random.vector(0.1));
    ChainModifier built(builder.build());
    built.add_displacement("l1", false, random.vector6(1e-4, 2e-4));
    built.add_transmission_error({.coordinate = 0, .shift = 1e-3});
    chains.push_back(std::move(built).chain());
  }
  return Manipulator("random", chains).with_gravity({0.5, 0, -9.81});
}

TEST(ManyEquilibria, OfRandomChainsWithLoadsOfAllKindsAsEachAlone) {
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Manipulator robot = random_robot(seed, 1, seed % 2 == 0 ? 0 : 1);
    RandomChains random(100 + seed);
    const Posture posture{.platform = Pose(), .coordinates = {robot.chains()[0].home()}};
    const std::vector<Posture> postures(6, posture);
    std::vector<Load> loads = loads_of(postures.size(), 50);
    for (Load& load : loads) {
      load.nodes.push_back(
          {.chain = 0, .node = robot.chains()[0].node_index("elbow"), .force = random.vector(30)});
      load.joints.push_back({.chain = 0, .coordinate = 0, .force = random.uniform(-20, 20)});
      load.gravity = random.uniform(0, 1);
    }
    found += expect_as_alone(robot, postures, loads);
  }
  EXPECT_GT(found, 60);
}

TEST(ManyEquilibria, APostureDoesNotKnowOfTheOthers) {
  const Manipulator robot = shipped("orthoglide.yaml").manipulator;
  const std::vector<Posture> postures = reached_of(robot, poses_about(robot, 0.05, 0, 13));
  std::vector<Load> loads = loads_of(postures.size(), 100);
  for (std::size_t i = 0; i < loads.size(); ++i)  // some are found sooner than others
    loads[i].force *= std::pow(10, static_cast<double>(i % 4) - 2);
  loads[1].force *= 1e7;  // which nothing carries
  const auto together = stable_equilibria(robot, postures, loads);
  for (std::size_t i = 0; i < postures.size(); ++i) {
    const auto alone = stable_equilibria(robot, {postures[i]}, {loads[i]}).front();
    ASSERT_EQ(alone.has_value(), together[i].has_value()) << i;
    if (!alone) continue;
    EXPECT_EQ(alone->platform.position(), together[i]->platform.position());
    EXPECT_EQ(alone->platform.rotation(), together[i]->platform.rotation());
    EXPECT_EQ(alone->stiffness.matrix(), together[i]->stiffness.matrix());
  }
}

// A column that would buckle, moments at nodes, a law in a joint: those go alone.
TEST(ManyEquilibria, WhatIsNotClearlyStableGoesAlone) {
  ChainBuilder builder("column");
  builder.actuator("foot", Motion::ry, 1000);
  for (const Motion motion : {Motion::tx, Motion::ty, Motion::tz, Motion::rx, Motion::rz})
    builder.actuator("stiff" + std::to_string(static_cast<int>(motion)), motion, 1e9);
  builder.offset(Pose::translation({0, 0, 1}));
  const Manipulator column("column", {builder.build()});
  const Posture posture = posture_from_joints(column, {}).posture;
  const auto found = stable_equilibria(column, {posture, posture, posture},
                                       {{{0, 0, -900}}, {{0, 0, -1100}}, {{0, 0, 1100}}});
  EXPECT_TRUE(found[0]);
  EXPECT_FALSE(found[1]);  // beyond k / l
  EXPECT_TRUE(found[2]);
  // k / l^2 - P / l, closed form
  EXPECT_NEAR(found[0]->stiffness.inverse().matrix()(0, 0), 1 / (1000 - 900.0), 1e-6);

  ChainModifier stopped(column.chains()[0]);
  stopped.add_law("foot", std::make_shared<StopLaw>(-0.1, 0.1, 1e5));
  const Manipulator with_law = column.with_chain(0, std::move(stopped).chain());
  EXPECT_FALSE(stable_equilibria(with_law, {posture}, {{{0, 0, -900}}}).front());

  const Manipulator robot = random_robot(3, 1, 0);
  const Posture home{.platform = Pose(), .coordinates = {robot.chains()[0].home()}};
  Load load;
  load.nodes.push_back({.chain = 0, .node = 0, .moment = Vector3(1, 0, 0)});
  EXPECT_FALSE(stable_equilibria(robot, {home}, {load}).front());
  EXPECT_TRUE(stable_equilibria(robot, {home}, {Load{}}).front());
}

// Loops within, or legs of rigid links.
TEST(ManyEquilibria, OtherRobotsGoAlone) {
  for (const char* file : {"heavy_arm.yaml", "stewart_gough_a.yaml", "orthoglide_frame.yaml"}) {
    const Manipulator robot = shipped(file).manipulator;
    const Posture home = posture_from_joints(robot, {}).posture;
    EXPECT_FALSE(stable_equilibria(robot, {home}, {{{1, 2, 3}}}).front()) << file;
  }
}

TEST(ManyEquilibria, NoneAreNoTrouble) {
  EXPECT_TRUE(stable_equilibria(shipped("orthoglide.yaml").manipulator, {}, {}).empty());
}

}  // namespace
}  // namespace kinetostat::vjm::equilibria_test
