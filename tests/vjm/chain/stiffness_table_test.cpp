// Drives whose stiffness depends on where they stand.
#include "kinetostat/vjm/chain/stiffness_table.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/joint_range.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/workspace/workspace_map.h"

namespace kinetostat::vjm {
namespace {

Robot slide(const std::string& stiffness, const std::string& more = "") {
  return parse_robot(
      "kinetostat: 1\nname: slide\nunits: {length: mm, force: N, angle: deg}\nchain_types:\n  c:\n"
      "    - actuator: {name: x, axis: Tx, home: 100, stiffness: " +
          stiffness + more + "}\nmanipulator: {chain: c}\n",
      "slide.yaml");
}

double compliance_at(const Robot& robot, double command) {
  const Posture posture = posture_from_joints(robot.manipulator, {{"x", command}}).posture;
  return equilibrium_under_load(robot.manipulator, posture, {.force = {50, 0, 0}})
             .displacement.coordinates()[0] /
         50;
}

// Compliance linear between supports, constant beyond.
TEST(StiffnessTable, IsThatOfAScrewOfTheLengthAtTheCommand) {
  const Robot robot = slide("{at: [0, 200, 300], is: [80 N/um, 40 N/um, 50 N/um]}");
  const double soft = 1 / 40e6, stiff = 1 / 80e6, last = 1 / 50e6;
  for (const auto& [command, compliance] : {std::pair(-0.05, stiff),
                                            {0.0, stiff},
                                            {0.05, stiff + 0.25 * (soft - stiff)},
                                            {0.1, (stiff + soft) / 2},
                                            {0.2, soft},
                                            {0.25, (soft + last) / 2},
                                            {0.4, last}})
    EXPECT_NEAR(compliance_at(robot, command), compliance, 1e-9 * compliance) << command;
}

// A factor on the spring is one on the whole table.
TEST(StiffnessTable, ScalesWithItsSpring) {
  const Robot robot = slide("{at: [0, 200], is: [80 N/um, 40 N/um]}");
  Robot scaled = robot;
  scaled.manipulator = with_scaled(robot.manipulator, {"x", {{0, "x"}}}, 0.7);
  for (const double command : {0.0, 0.07, 0.2})
    EXPECT_NEAR(compliance_at(scaled, command), compliance_at(robot, command) / 0.7, 1e-17);
}

TEST(StiffnessTable, NamesWhatIsWrongWithIt) {
  const auto says = [](const std::string& stiffness) -> std::string {
    try {
      (void)slide(stiffness);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto has = [&](const std::string& stiffness, const char* part) {
    EXPECT_NE(says(stiffness).find(part), std::string::npos) << says(stiffness);
  };
  has("{at: [0, 200], is: [80 N/um]}", "2 places and 1 values");
  has("{at: [0], is: [80 N/um]}", "two or more places");
  has("{at: [200, 0], is: [80 N/um, 40 N/um]}", "do not ascend");
  has("{at: [0, 200], is: [80 N/um, -40 N/um]}", "not positive");
  has("{at: [0, 200], is: [80 N/um, 40 N m]}", "slide.yaml");
}

TEST(JointRange, LeavesOutOfAMapWhatADriveCannotReach) {
  const Robot robot = slide("80 N/um", ", range: [0, 150]");
  const std::vector<MapIndex> indices = {{.kind = MapIndex::Kind::stiffness}};
  const auto state = [&](double x) {
    return map_point(robot.manipulator, {.platform = spatial::Pose::translation({x, 0, 0})},
                     indices)
        .state;
  };
  EXPECT_NE(state(0.15), MapState::unreachable);
  EXPECT_EQ(state(0.151), MapState::unreachable);
  EXPECT_EQ(state(-0.001), MapState::unreachable);
  const Posture beyond = posture_from_joints(robot.manipulator, {{"x", 0.2}}).posture;
  EXPECT_NE(beyond_range(robot.manipulator, beyond).find("200 mm, beyond its range of 0 to 150"),
            std::string::npos);
}

}  // namespace
}  // namespace kinetostat::vjm
