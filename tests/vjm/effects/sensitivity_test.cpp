#include "kinetostat/vjm/effects/sensitivity.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::sensitivity_test {
namespace {

using spatial::Pose;
using spatial::Vector6;

void expect_exact(const Manipulator& manipulator, const Posture& posture, const Load& load) {
  std::vector<SpringParameter> parameters;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    for (const Spring& spring : manipulator.chains()[c].springs())
      parameters.push_back({c, spring.name});
  const Equilibrium e = equilibrium_under_load(manipulator, posture, load);
  ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.reason;
  const auto exact = displacement_by_log_stiffness(manipulator, posture, load, e, parameters);
  const double h = 1e-4;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto& [chain, spring] = parameters[p];
    const auto solve = [&, chain = chain, spring = spring](double factor) {
      ChainModifier changed(manipulator.chains()[chain]);
      changed.scale_spring(spring, factor);
      return equilibrium_under_load(manipulator.with_chain(chain, changed.chain()), posture, load)
          .platform;
    };
    const Vector6 numerical =
        spatial::pose_difference(solve(std::exp(-h)), solve(std::exp(h))) / (2 * h);
    const Vector6 ours = exact.col(static_cast<Eigen::Index>(p));
    EXPECT_LT((numerical - ours).norm(), 1e-6 * exact.norm()) << spring;
  }
}

TEST(Sensitivity, EqualsCentralDifferencesOnAParallelRobot) {
  const Robot robot =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/orthoglide.yaml");
  const PostureResult posture =
      posture_at(robot.manipulator, Pose::translation({0.1, -0.03, 0.05}));
  ASSERT_TRUE(posture.reached);
  expect_exact(robot.manipulator, posture.posture,
               {{300, -200, 250}, {10, -20, 15}, {0.01, 0.02, 0}});
}

TEST(Sensitivity, EqualsCentralDifferencesOnARobotWithRigidDirections) {
  ChainBuilder chain("2R");
  chain.actuator("q1", Motion::rz, 500).offset(Pose::translation({0.4, 0, 0}));
  chain.actuator("q2", Motion::rz, 300).offset(Pose::translation({0.3, 0, 0}));
  const Manipulator arm("2R", {chain.build()});
  const Posture posture = posture_from_joints(arm, {{"q1", 0.3}, {"q2", 0.9}}).posture;
  expect_exact(arm, posture, {{40, -60, 10}});
}

TEST(Sensitivity, UnknownSpringsAreRefused) {
  ChainBuilder chain("c");
  chain.actuator("q", Motion::rz, 500);
  const Manipulator m("m", {chain.build()});
  const Posture posture = posture_from_joints(m, {}).posture;
  const Equilibrium e = equilibrium_under_load(m, posture, {});
  EXPECT_THROW(displacement_by_log_stiffness(m, posture, {}, e, {{0, "r"}}), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::vjm::sensitivity_test
