// Joints that are softer on one side, by their closed forms.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::vjm::one_sided_stiffness_test {
namespace {

class DirectionalStiffness : public testing::TestWithParam<double> {};

INSTANTIATE_TEST_SUITE_P(FromTheLeastToTheMost, DirectionalStiffness,
                         testing::Values(0.05, 0.1, 0.2, 0.6, 1.7, 20));

// A spring that is relaxed stands at its corner: loads lead away from it to either side.
TEST_P(DirectionalStiffness, IsFoundFromItsCornerOn) {
  constexpr double k = 1e6;
  const Robot robot = parse_robot(
      fmt::format("kinetostat: 1\nname: slide\nunits: {{length: m, force: N, angle: rad}}\n"
                  "chain_types:\n  cell:\n    - actuator: {{name: q, axis: Tz, stiffness: 1e6}}\n"
                  "manipulator: {{chain: cell}}\n"
                  "effects: [{{effect: directional_stiffness, at: q, ratio: {}}}]\n",
                  GetParam()),
      "slide.yaml");
  const Posture posture = posture_from_joints(robot.manipulator, {}).posture;
  for (const double force : {-5e3, -1.0, 1.0, 200.0, 5e3}) {
    const Equilibrium found =
        equilibrium_under_load(robot.manipulator, posture, {.force = {0, 0, force}});
    ASSERT_EQ(found.status, EquilibriumStatus::converged) << found.reason;
    const double exact = force / (force > 0 ? GetParam() * k : k);
    EXPECT_NEAR(found.displacement.translation.z(), exact, 1e-12 * std::abs(exact));
  }
}

}  // namespace
}  // namespace kinetostat::vjm::one_sided_stiffness_test
