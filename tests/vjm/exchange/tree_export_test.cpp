// What readers of the formats make of an exported robot (tree_reader.h): frames, springs, inertia.
#include "kinetostat/vjm/exchange/tree_export.h"

#include <cmath>
#include <map>
#include <regex>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/vjm/exchange/description_file.h"
#include "kinetostat/vjm/exchange/matlab_export.h"
#include "kinetostat/vjm/exchange/robot_import.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/stiffness.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

#include "support/random.h"
#include "support/temporary_folder.h"
#include "vjm/exchange/tree_reader.h"

namespace kinetostat::vjm::tree_export_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using test::ReadTree;
using testing::Contains;
using testing::HasSubstr;

// Joints of both kinds in frames turned anyhow, masses with full tensors, a passive spring that is
// not at rest.
Robot robot_of_all_kinds() {
  return parse_robot(
      "kinetostat: 1\nname: all \"kinds\" <1> -- \\ a\nunits: {length: m, force: N, angle: rad}\n"
      "gravity: {direction: [0.1, -0.2, -1]}\nlinks:\n"
      "  a: {rigid: {point: [0.3, 0.1, 0.2], rpy: [0.4, -0.5, 0.6]}, mass: {mass: 12, center: "
      "[0.1, 0.05, 0.1], inertia: [0.3, 0.02, -0.03, 0.4, 0.01, 0.5]}}\n"
      "  b: {rigid: {point: [0, 0.4, 0], rpy: [0, 1.5707963267948966, 0.3]}, mass: {mass: 7, "
      "center: [0, 0.2, 0]}}\n"
      "  c: {rigid: [0.2, 0, 0.3], mass: {mass: 3, center: [0.1, 0, 0.2], inertia: [0.03, 0, 0, "
      "0.04, 0, 0.05]}}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 3e4}\n    - link: a\n"
      "    - actuator: {name: q 2, axis: Tx, stiffness: 5e6}\n    - link: b\n"
      "    - passive: {name: p, axis: Ry, stiffness: 2e4, rest: 0.3, home: 0.3}\n    - link: c\n"
      "    - actuator: {name: held, axis: Rx}\n    - mass: {name: m, mass: 2, at: [0.1, 0.1, 0]}\n"
      "    - actuator: {name: q3, axis: Rx, stiffness: 1e4}\n    - link: c\n"
      "    - tool: {point: [0, 0, 0.1], rpy: [0.1, 0.2, 0.3]}\n"
      "manipulator: {chain: arm, base: {point: [1, 2, 3], rpy: [-0.3, 0.2, 0.1]}}\n",
      "all.yaml");
}

// All springs are relaxed in it, so that it is what files without a posture hold.
Posture posture_of(const Robot& robot) {
  return posture_from_joints(robot.manipulator,
                             {{"q1", 0.4}, {"q 2", 0.15}, {"p", 0.3}, {"held", -0.2}, {"q3", -0.8}})
      .posture;
}

struct Format {
  const char* name;
  std::string (*write)(const BodyTree& tree);
  ReadTree (*read)(const std::string& text);
  bool has_gravity;
};

class TreeExport : public testing::TestWithParam<Format> {
 protected:
  const Robot robot = robot_of_all_kinds();
  const Posture posture = posture_of(robot);

  ReadTree read(const TreeOptions& options = {}) const {
    return GetParam().read(GetParam().write(body_tree(robot, posture, options)));
  }
};

TEST_P(TreeExport, HasTheToolWhereTheRobotHasItAndItsGravity) {
  const ReadTree tree = read();
  ASSERT_EQ(tree.bodies.size(), 4u);
  EXPECT_LT((tree.tool.translation() - posture.platform.position()).norm(), 1e-12);
  EXPECT_LT((tree.tool.rotation() - posture.platform.rotation()).norm(), 1e-12);
  if (GetParam().has_gravity) {
    EXPECT_LT((tree.gravity - robot.manipulator.gravity()).norm(), 1e-12);
  }
}

TEST_P(TreeExport, GivesTheStaticAnswerOfTheRobot) {
  const spatial::Matrix6 exact =
      unloaded_stiffness(robot.manipulator, posture).compliance->matrix();
  EXPECT_LT((read().compliance() - exact).norm(), 1e-9 * exact.norm());
}

TEST_P(TreeExport, GivesTheFrequenciesOfTheRobot) {
  const ReadTree tree = read();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(tree.stiffness(), tree.mass());
  const NaturalModes exact = natural_modes(robot.manipulator, posture, 6);
  double mass = 0;
  for (const test::ReadBody& body : tree.bodies) mass += body.mass;
  EXPECT_NEAR(mass, exact.mass, 1e-6);
  ASSERT_EQ(exact.modes.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(std::sqrt(modes.eigenvalues()[static_cast<Index>(k)]) / (2 * M_PI),
                exact.modes[k].frequency, 1e-6 * exact.modes[k].frequency);
}

// Every spring has its damper: of a joint alone, 2 ratio sqrt(k m) with the inertia it moves.
TEST_P(TreeExport, HasDampersOfTheRatioThatIsAskedFor) {
  const ReadTree tree = read({.damping_ratio = 0.02});
  const MatrixXd mass = tree.mass();
  for (std::size_t b = 0; b < tree.bodies.size(); ++b) {
    const auto i = static_cast<Index>(b);
    EXPECT_NEAR(tree.bodies[b].damping, 0.04 * std::sqrt(tree.bodies[b].stiffness * mass(i, i)),
                1e-6 * tree.bodies[b].damping);
  }
  for (const test::ReadBody& body : read().bodies) EXPECT_EQ(body.damping, 0);
}

TEST_P(TreeExport, SaysInTheFileWhatItDoesNotHold) {
  const Robot bent = parse_robot(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\n"
      "materials: {steel: {E: 210 GPa, nu: 0.3, density: 7850 kg/m^3}}\n"
      "links:\n  upper--arm: {beam: {length: 1, section: {circle: {diameter: 0.05}}, material: "
      "steel}}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 1e5}\n"
      "    - link: upper--arm\n    - actuator: {name: q2, axis: Tz}\nmanipulator: {chain: arm}\n",
      "arm.yaml");
  const BodyTree tree = body_tree(bent, posture_from_joints(bent.manipulator, {}).posture);
  EXPECT_THAT(tree.lost, Contains(HasSubstr("link upper--arm is rigid")));
  const std::string text = GetParam().write(tree);
  EXPECT_THAT(text, HasSubstr("not in this file: link upper"));
  EXPECT_EQ(GetParam().read(text).bodies.size(), 1u);  // q2 holds its command
}

TEST_P(TreeExport, SaysThatStopsAreLostAndALinearSpringIsNot) {
  const Robot arm = parse_robot(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\nchain_types:\n  arm:\n"
      "    - actuator: {name: q1, axis: Rz, stiffness: 1e5}\n"
      "    - passive: {name: p, axis: Ry, stiffness: 500, stops: {upper: 0.3, stiffness: 1e5}}\n"
      "    - tool: [1, 0, 0]\nmanipulator: {chain: arm}\n"
      "effects: [{effect: joint_compliance, at: q1, c: 1e-5 rad/(N m)}, {effect: hardening, at: "
      "q1, k3: 1e9 N m/rad^3}]"
      "\n",
      "arm.yaml");
  const BodyTree tree = body_tree(arm, posture_from_joints(arm.manipulator, {}).posture);
  const std::string text = GetParam().write(tree);
  EXPECT_THAT(text, HasSubstr("not in this file: the stops of joint p"));
  EXPECT_THAT(text, HasSubstr("not in this file: effect hardening"));
  EXPECT_THAT(text, testing::Not(HasSubstr("effect joint_compliance")));
  EXPECT_NEAR(GetParam().read(text).bodies[0].stiffness, 5e4, 1e-6);  // 1e5 and 1 / 1e-5 in series
}

// Simulators drop bodies without mass, with all behind them, or give them a kilogram.
TEST_P(TreeExport, EveryBodyHasSomeInertiaWhereTheFormatWantsIt) {
  const Robot light = parse_robot(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\n"
      "links: {upper: {rigid: [1, 0, 0], mass: {mass: 2 kg, center: [0.5, 0, 0]}}}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 1e5, range: [-1, 1]}\n"
      "    - actuator: {name: q2, axis: Ry, stiffness: 1e5}\n    - link: upper\n"
      "    - actuator: {name: q3, axis: Rz, stiffness: 1e5}\nmanipulator: {chain: arm}\n",
      "arm.yaml");
  const BodyTree tree = body_tree(light, posture_from_joints(light.manipulator, {}).posture);
  const std::string text = GetParam().write(tree);
  if (std::string(GetParam().name) == "modelica") return;
  EXPECT_THAT(text, HasSubstr("behind q1, q2, q3: it has 2e-6 kg"));
  const ReadTree read = GetParam().read(text);
  ASSERT_EQ(read.bodies.size(), 3u);
  const MatrixXd mass = read.mass();
  EXPECT_NEAR(mass(1, 1), 2.0 / 3, 1e-5);  // a uniform rod
  EXPECT_GT(mass(2, 2), 1e-10);
  EXPECT_LT(mass(2, 2), 1e-8);
}

// A billionth of their own is what bodies get that have inertia, however small they are.
TEST_P(TreeExport, SmallBodiesKeepTheirInertia) {
  const Robot tiny = parse_robot(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\n"
      "links: {tip: {rigid: [0.01, 0, 0], mass: {mass: 1e-3 kg, center: [0.005, 0, 0], inertia: "
      "[2e-9, 0, 0, 3e-9, 0, 4e-9]}}}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 1}\n"
      "    - link: tip\nmanipulator: {chain: arm}\n",
      "arm.yaml");
  const BodyTree tree = body_tree(tiny, posture_from_joints(tiny.manipulator, {}).posture);
  const double exact = 4e-9 + 1e-3 * 0.005 * 0.005;
  EXPECT_NEAR(GetParam().read(GetParam().write(tree)).mass()(0, 0) / exact, 1, 1e-8);
}

// Modelica's joints have none; the program's own readers find the others.
TEST_P(TreeExport, HasTheRangesOfJointsOrSaysThatItHasNone) {
  const Robot ranged = parse_robot(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\nchain_types:\n  arm:\n"
      "    - actuator: {name: q1, axis: Rz, stiffness: 1e5, range: [-1, 0.5]}\n"
      "    - actuator: {name: q2, axis: Tx, stiffness: 1e5, range: [0.1, 0.3], home: 0.2}\n"
      "    - actuator: {name: q3, axis: Ry, stiffness: 1e5}\nmanipulator: {chain: arm}\n",
      "arm.yaml");
  const BodyTree tree = body_tree(ranged, posture_from_joints(ranged.manipulator, {}).posture);
  const std::string text = GetParam().write(tree), name = GetParam().name;
  if (name == "modelica") {
    EXPECT_THAT(text, HasSubstr("not in this file: ranges of joints"));
    return;
  }
  EXPECT_THAT(text, testing::Not(HasSubstr("ranges of joints")));
  const test::TemporaryFolder folder;
  const RobotDescription read =
      read_robot_description(folder.file("a." + (name == "mjcf" ? "xml" : name), text));
  const std::vector<DescribedJoint> drives =
      import_robot(read, find_chain(read, "world", "tool")).drives;
  ASSERT_EQ(drives.size(), 3u);
  EXPECT_THAT(drives[0].limits, testing::Optional(testing::ElementsAre(-1, 0.5)));
  EXPECT_THAT(drives[1].limits, testing::Optional(testing::ElementsAre(0.1, 0.3)));
  EXPECT_FALSE(drives[2].limits);
}

// A screw, a slide that goes with another one, a joint that turns with another one, and one that
// turns with a slide: the files have them move together, with the spring at the first.
TEST_P(TreeExport, JointsMayFollowOthers) {
  const Robot coupled = parse_robot(
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\nlinks:\n"
      "  a: {rigid: {point: [0.3, 0.1, 0.2], rpy: [0.4, -0.5, 0.6]}, mass: {mass: 5, center: "
      "[0.1, 0.05, 0.1], inertia: [0.3, 0.02, -0.03, 0.4, 0.01, 0.5]}}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q, axis: Rz, stiffness: 3e4}\n    - link: a\n"
      "    - coupled: {to: q, axis: Ry, factor: -0.5}\n    - link: a\n"
      "    - coupled: {to: q, axis: Tx, factor: 0.02 m/rad}\n    - link: a\n"
      "    - actuator: {name: s, axis: Tz, stiffness: 5e6}\n    - link: a\n"
      "    - coupled: {to: s, axis: Ty, factor: 2}\n    - link: a\n"
      "    - coupled: {to: s, axis: Rx, factor: 3 rad/m}\n    - link: a\n"
      "manipulator: {chain: arm}\n",
      "arm.yaml");
  // In it the springs are relaxed.
  const Posture at_rest =
      posture_from_joints(coupled.manipulator, {{"q", 0.4}, {"s", 0.1}}).posture;
  const std::string text = GetParam().write(body_tree(coupled, at_rest, {.damping_ratio = 0.02}));
  const ReadTree tree = GetParam().read(text);
  ASSERT_EQ(tree.bodies.size(), 6u);
  EXPECT_EQ(text.find("follows") != std::string::npos, std::string(GetParam().name) == "mjcf");
  EXPECT_LT((tree.tool.translation() - at_rest.platform.position()).norm(), 1e-12);
  const spatial::Matrix6 exact =
      unloaded_stiffness(coupled.manipulator, at_rest).compliance->matrix();
  EXPECT_LT((tree.compliance() - exact).norm(), 1e-9 * exact.norm());
  const MatrixXd mass = tree.mass();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(tree.stiffness(), mass);
  const NaturalModes of_robot = natural_modes(coupled.manipulator, at_rest, 6);
  ASSERT_EQ(of_robot.modes.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(std::sqrt(modes.eigenvalues()[static_cast<Index>(k)]) / (2 * M_PI),
                of_robot.modes[k].frequency, 1e-6 * of_robot.modes[k].frequency);
  EXPECT_NEAR(tree.bodies[0].damping, 0.04 * std::sqrt(3e4 * mass(0, 0)), 1e-6);
  EXPECT_NEAR(tree.bodies[3].damping, 0.04 * std::sqrt(5e6 * mass(1, 1)), 1e-6);
}

// Names of the file's own beside those of the robot.
TEST_P(TreeExport, NoTwoThingsHaveOneName) {
  std::string text =
      "kinetostat: 1\nname: arm\nunits: {length: m, force: N, angle: rad}\nchain_types:\n  arm:\n";
  for (const char* name : {"tool", "tool_joint", "base", "base_joint", "world", "a", "a_link_"})
    text += fmt::format("    - actuator: {{name: {}, axis: Rz, stiffness: 1e5}}\n", name);
  const Robot robot = parse_robot(text + "manipulator: {chain: arm}\n", "arm.yaml");
  const std::string file =
      GetParam().write(body_tree(robot, posture_from_joints(robot.manipulator, {}).posture));
  std::map<std::string, int> count;
  const std::regex named("<(link|joint|frame|body)[^>]* name=\"([^\"]*)\"");
  const bool one_list = std::string(GetParam().name) == "sdf";  // else a list for each kind
  for (std::sregex_iterator at(file.begin(), file.end(), named), end; at != end; ++at)
    ++count[(one_list ? "" : at->str(1) + " ") + at->str(2)];
  for (const auto& [name, times] : count) EXPECT_EQ(times, 1) << name;
  EXPECT_THAT(file, testing::Not(HasSubstr("joint name=\"world\"")));
}

INSTANTIATE_TEST_SUITE_P(All, TreeExport,
                         testing::Values(Format{"mjcf", mjcf, test::read_mjcf_text, true},
                                         Format{"urdf", urdf, test::read_urdf_text, false},
                                         Format{"sdf", sdf, test::read_sdf_text, true},
                                         Format{"modelica", modelica, test::read_modelica_text,
                                                true}),
                         [](const auto& format) { return std::string(format.param.name); });

TEST(BodyTree, RefusesWhatIsNoSerialRobot) {
  const Robot robot = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/delta.yaml");
  EXPECT_THROW(body_tree(robot, posture_from_joints(robot.manipulator, {}).posture),
               std::invalid_argument);
}

TEST(BodyTree, RollPitchAndYawGiveTheRotationBackAtTheirPolesToo) {
  test::Random random(3);
  for (int i = 0; i < 200; ++i) {
    const double up = M_PI / 2 - (i % 4 == 0 ? 0 : std::pow(10, -i / 10.0));
    const spatial::Matrix3 rotation = spatial::rotation_from_rpy(
        {random.uniform(-3, 3), i % 2 == 0 ? up : -up, random.uniform(-3, 3)});
    EXPECT_LT((spatial::rotation_from_rpy(roll_pitch_yaw(rotation)) - rotation).norm(), 1e-14);
  }
}

// The files read by the program's own readers: the same robot again, links and gravity too.
TEST(TreeExport, ComesBackThroughTheImport) {
  const Robot robot = robot_of_all_kinds();
  const Posture posture = posture_of(robot);
  const BodyTree tree = body_tree(robot, posture);
  const test::TemporaryFolder folder;
  const spatial::Matrix6 exact =
      unloaded_stiffness(robot.manipulator, posture).compliance->matrix();
  for (const auto& [name, text] :
       {std::pair{"a.urdf", urdf(tree)}, {"a.sdf", sdf(tree)}, {"a.xml", mjcf(tree)}}) {
    const RobotDescription read = read_robot_description(folder.file(name, text));
    const ImportedRobot imported = import_robot(read, find_chain(read, "world", "tool"));
    const Robot again = parse_robot(imported.text, folder.path() / "again.yaml");
    const Posture there =
        posture_from_joints(again.manipulator,
                            {{"q1", 0.4}, {"q 2", 0.15}, {"p", 0.3}, {"q3", -0.8}})
            .posture;
    const NaturalModes before = natural_modes(robot.manipulator, posture, 4),
                       behind = natural_modes(again.manipulator, there, 4);
    ASSERT_EQ(behind.modes.size(), 4u) << name;
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(behind.modes[k].frequency, before.modes[k].frequency,
                  1e-6 * before.modes[k].frequency)
          << name;
    EXPECT_LT((unloaded_stiffness(again.manipulator, there).compliance->matrix() - exact).norm(),
              1e-9 * exact.norm())
        << name;
  }
}

TEST(MatlabExport, SaysThatARobotWithoutMassesHasNone) {
  const Robot light = read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/six_axis.yaml");
  const Robot heavy = robot_of_all_kinds();
  EXPECT_THAT(lost_in_matlab(light), Contains(HasSubstr("M is 0")));
  EXPECT_THAT(matlab(light, posture_from_joints(light.manipulator, {}).posture),
              HasSubstr("M is 0"));
  EXPECT_THAT(matlab(heavy, posture_of(heavy)), HasSubstr("%   y: motions that all joints"));
  EXPECT_THAT(lost_in_matlab(heavy), testing::Not(Contains(HasSubstr("M is 0"))));
}

// Of closed chains with elastic links, too: K, M and J give compliance and frequencies.
TEST(MatlabExport, GivesComplianceAndFrequenciesOfAnyRobot) {
  const Robot arm = robot_of_all_kinds();
  const std::string text =
      io::read_text(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/heavy_arm.yaml");
  const Robot heavy =
      parse_robot(text, std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/heavy_arm.yaml");
  for (const auto& [robot, posture] :
       {std::pair{&arm, posture_of(arm)},
        std::pair{&heavy, posture_from_joints(heavy.manipulator, {}).posture}}) {
    const std::string script = matlab(*robot, posture, 0.01);
    const MatrixXd k = test::read_matrix(script, "K"), m = test::read_matrix(script, "M"),
                   d = test::read_matrix(script, "D"), j = test::read_matrix(script, "J");
    const spatial::Matrix6 exact =
        unloaded_stiffness(robot->manipulator, posture).compliance->matrix();
    EXPECT_LT((j * k.ldlt().solve(j.transpose()) - exact).norm(), 1e-6 * exact.norm());
    const NaturalModes modes = natural_modes(robot->manipulator, posture, 6);
    // M x = theta K x has no trouble with motions without mass.
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> found(m, k);
    for (std::size_t i = 0; i < modes.modes.size(); ++i) {
      const Index at = m.rows() - 1 - static_cast<Index>(i);
      const double omega = 1 / std::sqrt(found.eigenvalues()[at]);
      EXPECT_NEAR(omega / (2 * M_PI), modes.modes[i].frequency, 1e-6 * modes.modes[i].frequency);
      const Eigen::VectorXd x = found.eigenvectors().col(at);
      EXPECT_NEAR(x.dot(d * x), 2 * 0.01 * omega * x.dot(m * x), 1e-5 * omega * x.dot(m * x));
    }
  }
}

}  // namespace
}  // namespace kinetostat::vjm::tree_export_test
