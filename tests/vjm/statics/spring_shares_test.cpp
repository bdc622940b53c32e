#include "kinetostat/vjm/statics/spring_shares.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::vjm::spring_shares_test {
namespace {

using spatial::Vector3;

// Springs in series yield in proportion to their compliances.
TEST(SpringShares, OfTwoSlidesInSeriesAreTheirCompliances) {
  const Chain chain =
      ChainBuilder("slides").actuator("a", Motion::tx, 1e6).actuator("b", Motion::tx, 3e6).build();
  const Manipulator slides("slides", {chain});
  const Posture posture = posture_from_joints(slides, {}).posture;
  const auto shares = spring_shares(slides, posture, Vector3::UnitX());
  ASSERT_EQ(shares.size(), 2u);
  EXPECT_EQ(shares[0].spring, "a");
  EXPECT_NEAR(shares[0].share, 0.75, 1e-6);
  EXPECT_NEAR(shares[1].share, 0.25, 1e-6);
  EXPECT_TRUE(spring_shares(slides, posture, Vector3::UnitY()).empty());  // rigid that way
}

// What a stiffer spring would gain: the derivative of the compliance, by differences.
TEST(SpringShares, AreTheDerivativesOfTheCompliance) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/six_axis.yaml");
  const Vector3 direction = Vector3(-0.4, 0.1, -0.9).normalized();
  const auto compliance = [&](const Manipulator& manipulator) {
    const auto unloaded =
        unloaded_stiffness(manipulator, posture_from_joints(manipulator, {}).posture);
    return direction.dot(unloaded.compliance->matrix().topLeftCorner<3, 3>() * direction);
  };
  const double c = compliance(robot.manipulator);
  double sum = 0;
  for (const SpringShare& s : spring_shares(
           robot.manipulator, posture_from_joints(robot.manipulator, {}).posture, direction)) {
    constexpr double step = 1e-4;
    const UncertainStiffness spring{s.spring, {{s.chain, s.spring}}};
    const double derivative =
        (compliance(with_scaled(robot.manipulator, spring, std::exp(step))) -
         compliance(with_scaled(robot.manipulator, spring, std::exp(-step)))) /
        (2 * step * c);
    EXPECT_NEAR(s.share, -derivative, 2e-5) << s.spring;
    sum += s.share;
  }
  EXPECT_NEAR(sum, 1, 1e-4);
}

}  // namespace
}  // namespace kinetostat::vjm::spring_shares_test
