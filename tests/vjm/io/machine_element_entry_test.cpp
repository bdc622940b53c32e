#include "kinetostat/vjm/io/machine_element_entry.h"

#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/machine_elements/ball_screw.h"
#include "kinetostat/vjm/machine_elements/bearing.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"

#include "vjm/robot_text.h"

namespace kinetostat::vjm::machine_element_entry_test {
namespace {

using testing::HasSubstr;

// A table that a bearing lets turn and a drive holds, and a slide on its guide that a screw moves.
std::string machine(const std::string& bearing, const std::string& guide,
                    const std::string& screw) {
  return fmt::format(R"(kinetostat: 1
name: machine
units: {{length: mm, force: N, angle: deg}}
links:
  bearing: {{bearing: {{{}}}}}
  guide: {{guide: {{{}}}}}
chain_types:
  table:
    - link: bearing
  slide:
    - link: guide
  drive:
    - actuator: {{name: x, axis: Tx, home: 100, stiffness: {{ball_screw: {{{}}}}}}}
manipulator: {{chain: drive}}
)",
                     bearing, guide, screw);
}

const char* const usual_bearing =
    "balls: 16, ball_diameter: 9, pitch_diameter: 60, contact_angle: 25, preload: 500, "
    "arrangement: back-to-back, spacing: 40";
const char* const usual_guide =
    "lateral: 300 N/um, normal: 500 N/um, carriages: [[-200, -150, 0], [200, -150, 0], "
    "[-200, 150, 0], [200, 150, 0]]";
const char* const usual_screw =
    "core_diameter: 27, length: 900, zero: 100, nut: 450 N/um, bearing: 600 N/um";

std::string complaint(const std::string& text) {
  try {
    (void)robot_from(text);
  } catch (const common::InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(BearingEntry, TurnsFreelyAndIsTheMatrixOfItsRows) {
  std::string text = machine(usual_bearing, usual_guide, usual_screw);
  text.replace(text.find("{chain: drive}"), 14, "{chain: table}");
  const Robot robot = robot_from(text);
  const Chain& chain = robot.without_effects().chains()[0];
  ASSERT_EQ(chain.springs().size(), 1u);
  std::vector<PreloadedRow> rows;
  for (const double side : {1., -1.}) {
    const BearingRow row =
        ball_row(16, 9e-3, 60e-3, -side * 25 * std::numbers::pi / 180, 0.52, 0.52, side * 20e-3);
    rows.push_back({row, axial_approach(row, -side * 500)});
  }
  const spatial::Matrix6 expected = bearing_stiffness(rows), found = chain.springs()[0].stiffness;
  EXPECT_LT((found - expected).block(0, 0, 5, 5).norm(), 1e-9 * expected.norm());
  ASSERT_EQ(chain.size(), 7);  // the free turn, a joint
  EXPECT_EQ(chain.coordinates()[6].role, Role::passive);
}

// What a drive holds is no joint, and yields nothing worth the name.
TEST(BearingEntry, MayBeHeldByADrive) {
  std::string text = machine(std::string(usual_bearing) + ", held: true", usual_guide, usual_screw);
  text.replace(text.find("{chain: drive}"), 14, "{chain: table}");
  const Robot robot = robot_from(text);
  const Chain& chain = robot.without_effects().chains()[0];
  EXPECT_EQ(chain.size(), 6);
  const spatial::Matrix6 k = chain.springs()[0].stiffness;
  EXPECT_GT(k(5, 5), 100 * k(3, 3));
  EXPECT_NEAR(k(0, 5), 0, 1e-6 * k(0, 0));
}

TEST(GuideEntry, SlidesFreelyAlongItsRail) {
  std::string text = machine(usual_bearing, usual_guide, usual_screw);
  text.replace(text.find("{chain: drive}"), 14, "{chain: slide}");
  const Robot robot = robot_from(text);
  const Chain& chain = robot.without_effects().chains()[0];
  const spatial::Matrix6 k = chain.springs()[0].stiffness;
  EXPECT_NEAR(k(1, 1), 4 * 300e6, 1);
  EXPECT_NEAR(k(3, 3), 4 * 500e6 * 0.15 * 0.15, 1);
  EXPECT_EQ(chain.size(), 7);
}

// The carriages travel with the table: what it yields to a load does not depend on where it stands.
TEST(GuideEntry, ItsCarriagesTravelWithTheTable) {
  std::string text = machine(usual_bearing, usual_guide, usual_screw);
  text.replace(text.find("{chain: drive}"), 14, "{chain: slide}");
  const Robot robot = robot_from(text);
  const Manipulator& table = robot.without_effects();
  const auto stiffness_at = [&](double along) {
    const Posture posture = posture_from_joints(table, {{"guide.free1", along}}).posture;
    const spatial::Frame there{posture.platform.position(), posture.platform.rotation()};
    return unloaded_stiffness(table, posture).stiffness->in(there).matrix();
  };
  const spatial::Matrix6 home = stiffness_at(0), away = stiffness_at(0.6);
  EXPECT_NEAR(home(2, 2), 4 * 500e6, 1);
  EXPECT_LT((away - home).norm(), 1e-9 * home.norm());
}

TEST(BallScrewEntry, IsStiffestNearItsBearing) {
  const Robot robot = robot_from(machine(usual_bearing, usual_guide, usual_screw));
  const Chain& chain = robot.without_effects().chains()[0];
  const BallScrew screw{.shaft_area = std::numbers::pi / 4 * 27e-3 * 27e-3,
                        .length = 0.9,
                        .nut = 450e6,
                        .bearing = 600e6};
  EXPECT_NEAR(chain.springs()[0].stiffness(0, 0), axial_stiffness(screw, 0.2), 1);
}

TEST(MachineElements, KnowHowWellTheyAreKnown) {
  const Robot robot =
      robot_from(machine(std::string(usual_bearing) + ", factor: {value: 1, sd: 10 %}", usual_guide,
                         std::string(usual_screw)));
  ASSERT_EQ(robot.sources.size(), 1u);
  EXPECT_EQ(robot.sources[0].name, "factor of bearing");
  EXPECT_EQ(to_string(robot.sources[0].kind), "machine element");
}

TEST(MachineElements, SayWhatIsWrong) {
  const auto bearing = [](const std::string& text) {
    return complaint(machine(text, usual_guide, usual_screw));
  };
  EXPECT_THAT(
      bearing("balls: 16, ball_diameter: 9, pitch_diameter: 60, contact_angle: 0, preload: 5"),
      HasSubstr("does not load a bearing whose contact angle is zero"));
  EXPECT_THAT(
      bearing("balls: 16, ball_diameter: 90, pitch_diameter: 60, contact_angle: 10, preload: 5"),
      HasSubstr("larger than the bearing"));
  EXPECT_THAT(
      bearing("balls: 2, ball_diameter: 9, pitch_diameter: 60, contact_angle: 10, preload: 5"),
      HasSubstr("3 to 1000"));
  EXPECT_THAT(bearing("balls: 9, ball_diameter: 9, pitch_diameter: 60, contact_angle: 10"),
              HasSubstr("preload"));
  EXPECT_THAT(bearing("balls: 9, ball_diameter: 9, pitch_diameter: 60, contact_angle: 10, "
                      "preload: 5, spacing: 20"),
              HasSubstr("one row has no spacing"));
  EXPECT_THAT(bearing("balls: 9, ball_diameter: 9, pitch_diameter: 60, contact_angle: 10, "
                      "preload: 5, arrangement: tandem"),
              HasSubstr("back-to-back"));
  EXPECT_THAT(complaint(machine(usual_bearing, "lateral: 300 N/um, normal: 500 N/um", usual_screw)),
              HasSubstr("nothing of this guide resists its roll"));
  EXPECT_THAT(complaint(machine(usual_bearing, usual_guide,
                                "core_diameter: 27, length: 900, zero: 100, nut: 450 N/um")),
              HasSubstr("bearing"));
  std::string turning = machine(usual_bearing, usual_guide, usual_screw);
  turning.replace(turning.find("Tx"), 2, "Rx");
  EXPECT_THAT(complaint(turning), HasSubstr("this joint turns"));
}

}  // namespace
}  // namespace kinetostat::vjm::machine_element_entry_test
