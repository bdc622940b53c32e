#include <fstream>
#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/exchange/robot_import.h"
#include "kinetostat/vjm/exchange/urdf_import.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/joint_range.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "support/random.h"
#include "support/temporary_folder.h"

namespace kinetostat::vjm::urdf_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using testing::HasSubstr;

class Urdf : public testing::Test {
 protected:
  test::TemporaryFolder folder;

  RobotDescription read(const std::string& text) const {
    const auto file = folder.path() / "robot.urdf";
    std::ofstream(file) << text;
    return read_urdf(file);
  }
  Robot imported(const RobotDescription& model, const DescribedChain& chain) const {
    const auto file = folder.path() / "robot.yaml";
    std::ofstream(file) << import_robot(model, chain).text;
    return read_robot(file);
  }
  void expect_refused(const std::string& text, const std::string& message) const {
    try {
      const RobotDescription model = read(text);
      import_robot(model, find_chain(model, "", ""));
      ADD_FAILURE() << "accepted: " << text;
    } catch (const common::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(message));
    }
  }
};

// Links a and b with a joint between them, whose insides and type are given.
std::string two_links(const std::string& type, const std::string& inside = "") {
  return "<robot name='r'>\n<link name='a'/>\n<link name='b'/>\n<joint name='j' type='" + type +
         "'>\n<parent link='a'/><child link='b'/>" + inside + "</joint>\n</robot>\n";
}

struct Motion6 {
  std::map<std::string, double> joints;
  Pose tip;                                // by URDF's own rule
  std::map<std::string, Vector3> centers;  // of masses, per link
};

// Direct kinematics as URDF defines it: origin, then rotation about the axis in the child frame.
Motion6 moved(const RobotDescription& model, const DescribedChain& chain, test::Random& random) {
  Motion6 motion;
  for (const std::size_t number : chain.joints) {
    const DescribedJoint& joint = model.joints[number];
    motion.tip = motion.tip * joint.origin;
    if (joint.type != JointType::fixed) {
      double q = random.uniform(-1, 1);
      if (joint.mimics.empty()) motion.joints[joint.name] = q;
      if (!joint.mimics.empty())
        q = joint.mimic_factor * motion.joints.at(joint.mimics) + joint.mimic_offset;
      motion.tip = motion.tip * (joint.type == JointType::prismatic
                                     ? Pose::translation(q * joint.axis)
                                     : Pose::rotation(spatial::exp_rotation(q * joint.axis)));
    }
    for (const DescribedLink& link : model.links) {
      if (link.name == joint.child && link.inertia)
        motion.centers[link.name] = motion.tip * link.inertia->center;
      const DescribedJoint* carrier = carrier_of(model, link.name);
      if (carrier != nullptr && carrier->parent == joint.child &&
          carrier->type == JointType::fixed && link.inertia)
        motion.centers[link.name] = motion.tip * carrier->origin * link.inertia->center;
    }
  }
  return motion;
}

TEST_F(Urdf, ImportedArmMovesAsTheUrdfSays) {
  const RobotDescription model =
      read_urdf(std::string(KINETOSTAT_SOURCE_DIR) + "/data/urdf/six_axis.urdf");
  const DescribedChain chain = find_chain(model, "", "flange");
  const Robot robot = imported(model, chain);
  test::Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Motion6 motion = moved(model, chain, random);
    const PostureResult result = posture_from_joints(robot.manipulator, motion.joints);
    ASSERT_TRUE(result.reached) << result.reason;
    EXPECT_LT(spatial::pose_difference(result.posture.platform, motion.tip).norm(), 1e-12);
  }
}

TEST_F(Urdf, MassesAndTheirCentresArriveWithWhatIsFixedToThem) {
  const RobotDescription model =
      read_urdf(std::string(KINETOSTAT_SOURCE_DIR) + "/data/urdf/six_axis.urdf");
  const DescribedChain chain = find_chain(model, "", "flange");
  const Robot robot = imported(model, chain);
  test::Random random(8);
  const Motion6 motion = moved(model, chain, random);
  const Posture posture = posture_from_joints(robot.manipulator, motion.joints).posture;
  ChainKinematics kinematics;
  const Chain& arm = robot.manipulator.chains()[0];
  evaluate(arm, posture.coordinates[0], kinematics);
  double mass = 0;
  Vector3 moment = Vector3::Zero();
  for (const PointMass& point : arm.masses()) {
    mass += point.mass;
    moment += point.mass * kinematics.nodes[point.node];
  }
  double expected_mass = 0;
  Vector3 expected = Vector3::Zero();
  for (const DescribedLink& link : model.links)
    if (motion.centers.contains(link.name)) {
      expected_mass += link.inertia->mass;
      expected += link.inertia->mass * motion.centers.at(link.name);
    }
  ASSERT_TRUE(motion.centers.contains("camera_bracket"));  // fixed to the forearm, beside the chain
  EXPECT_NEAR(mass, expected_mass, 1e-12);
  EXPECT_LT((moment - expected).norm(), 1e-12 * expected_mass);
}

TEST_F(Urdf, FixedLinksOfTheChainLendTheirMassToTheLinkBefore) {
  const std::string text =
      "<robot name='r'><link name='a'/><link name='b'><inertial><origin xyz='1 0 0'/><mass "
      "value='2'/></inertial></link><link name='c'><inertial><mass value='3'/></inertial></link>"
      "<joint name='j' type='revolute'><parent link='a'/><child link='b'/></joint>"
      "<joint name='f' type='fixed'><parent link='b'/><child link='c'/><origin xyz='0 2 0' "
      "rpy='0 0 1'/></joint></robot>";
  const RobotDescription model = read(text);
  const Robot robot = imported(model, find_chain(model, "", ""));
  double mass = 0;
  Vector3 moment = Vector3::Zero();
  ChainKinematics kinematics;
  const Chain& arm = robot.manipulator.chains()[0];
  evaluate(arm, arm.home(), kinematics);
  for (const PointMass& point : arm.masses()) {
    mass += point.mass;
    moment += point.mass * kinematics.nodes[point.node];
  }
  EXPECT_NEAR(mass, 5, 1e-14);
  EXPECT_LT((moment - Vector3(2, 6, 0)).norm(), 1e-13);
}

TEST_F(Urdf, SlidesMimicJointsAndObliqueAxes) {
  const std::string text =
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/>"
      "<joint name='slide' type='prismatic'><parent link='a'/><child link='b'/><origin xyz='.1 0 "
      "0' rpy='.3 .2 .1'/><axis xyz='1 1 0'/><limit lower='1' upper='2'/></joint>"
      "<joint name='turn' type='continuous'><parent link='b'/><child link='c'/><axis xyz='0 0 "
      "-1'/></joint>"
      "<joint name='same' type='revolute'><parent link='c'/><child link='d'/><axis xyz='1 2 3'/>"
      "<mimic joint='turn' multiplier='-2' offset='.4'/></joint></robot>";
  const RobotDescription model = read(text);
  const DescribedChain chain = find_chain(model, "", "");
  const Robot robot = imported(model, chain);
  EXPECT_EQ(robot.manipulator.chains()[0].coordinates()[0].home, 1.5);
  test::Random random(2);
  const Motion6 motion = moved(model, chain, random);
  const PostureResult result = posture_from_joints(robot.manipulator, motion.joints);
  EXPECT_LT(spatial::pose_difference(result.posture.platform, motion.tip).norm(), 1e-12);
}

// A slide that a turn drives through a screw, and a turn that a slide drives.
TEST_F(Urdf, AMimicMayTurnWhatSlides) {
  const std::string text =
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='d'/><link "
      "name='e'/>"
      "<joint name='turn' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 1 "
      "0'/></joint>"
      "<joint name='nut' type='prismatic'><parent link='b'/><child link='c'/><axis xyz='1 0 0'/>"
      "<mimic joint='turn' multiplier='-0.03' offset='.1'/></joint>"
      "<joint name='slide' type='prismatic'><parent link='c'/><child link='d'/><axis xyz='0 0 "
      "1'/><limit lower='0' upper='2'/></joint>"
      "<joint name='wheel' type='revolute'><parent link='d'/><child link='e'/><axis xyz='1 2 3'/>"
      "<mimic joint='slide' multiplier='4'/></joint></robot>";
  const RobotDescription model = read(text);
  const DescribedChain chain = find_chain(model, "", "");
  const Robot robot = imported(model, chain);
  test::Random random(3);
  const Motion6 motion = moved(model, chain, random);
  const PostureResult result = posture_from_joints(robot.manipulator, motion.joints);
  EXPECT_LT(spatial::pose_difference(result.posture.platform, motion.tip).norm(), 1e-12);
}

// A linkage whose driven joint is on a branch beside the chain: q1 = 2 q - 0.1, q2 = -q1 / 4 + 0.3.
TEST_F(Urdf, AMimicMayFollowAJointOfASideBranch) {
  const std::string text =
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='side'/>"
      "<joint name='crank' type='continuous'><parent link='a'/><child link='side'/></joint>"
      "<joint name='one' type='continuous'><parent link='a'/><child link='b'/><origin xyz='0 0 "
      ".3'/><axis xyz='0 1 0'/><mimic joint='crank' multiplier='2' offset='-.1'/></joint>"
      "<joint name='two' type='continuous'><parent link='b'/><child link='c'/><origin xyz='.4 0 "
      "0'/><axis xyz='0 1 0'/><mimic joint='one' multiplier='-.25' offset='.3'/></joint></robot>";
  const RobotDescription model = read(text);
  const Robot robot = imported(model, find_chain(model, "a", "c"));
  const double q1 = 0.7, q2 = -q1 / 4 + 0.3;
  const PostureResult result = posture_from_joints(robot.manipulator, {{"one", q1}});
  const Pose tip =
      Pose::translation({0, 0, 0.3}) * Pose::rotation(spatial::exp_rotation(Vector3(0, q1, 0))) *
      Pose::translation({0.4, 0, 0}) * Pose::rotation(spatial::exp_rotation(Vector3(0, q2, 0)));
  EXPECT_LT(spatial::pose_difference(result.posture.platform, tip).norm(), 1e-12);
}

// q1 = -2 q2: the energy of the spring of q2 is k2 q1^2 / 8, and q1 goes where q2 may go.
TEST_F(Urdf, AJointInPlaceOfItsLeaderHasWhatThatHas) {
  RobotDescription model = read(
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
      "<joint name='one' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>"
      "<limit lower='-3' upper='0.3' effort='10' velocity='1'/><mimic joint='two' "
      "multiplier='-2'/></joint>"
      "<joint name='two' type='revolute'><parent link='b'/><child link='c'/><origin xyz='1 0 0'/>"
      "<axis xyz='0 0 1'/><limit lower='-.2' upper='.4' effort='100' "
      "velocity='1'/></joint></robot>");
  model.joints[1].stiffness = 5000;
  const ImportedRobot robot = import_robot(model, find_chain(model, "", ""));
  ASSERT_EQ(robot.drives.size(), 1u);
  EXPECT_DOUBLE_EQ(robot.drives[0].stiffness.value(), 1250);
  EXPECT_DOUBLE_EQ(robot.drives[0].effort.value(), 50);
  EXPECT_DOUBLE_EQ(robot.drives[0].limits->front(), -0.8);
  EXPECT_DOUBLE_EQ(robot.drives[0].limits->back(), 0.3);
  const Robot read_again = imported(model, find_chain(model, "", ""));
  EXPECT_DOUBLE_EQ(read_again.manipulator.chains()[0].springs().at(0).stiffness(0, 0), 1250);
}

// A finger that moves beside the chain, a drive that follows what cannot move, a limit of 110 deg.
TEST_F(Urdf, BranchesFixedLeadersAndLimitsArriveAsTheyAre) {
  const RobotDescription model = read(
      "<robot name='r'><link name='a'/><link name='b'/><link name='c'/><link name='finger'>"
      "<inertial><mass value='.25'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>"
      "</inertial></link><link name='stop'/>"
      "<joint name='one' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>"
      "<limit lower='-1.9198621771937625' upper='1.9198621771937625' effort='1' velocity='1'/>"
      "</joint><joint name='two' type='continuous'><parent link='b'/><child link='c'/>"
      "<axis xyz='0 0 1'/><mimic joint='still' multiplier='3' offset='.5'/></joint>"
      "<joint name='grip' type='prismatic'><parent link='b'/><child link='finger'/>"
      "<axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint>"
      "<joint name='still' type='fixed'><parent link='b'/><child link='stop'/></joint></robot>");
  const DescribedChain chain = find_chain(model, "a", "c");
  const ImportedRobot robot = import_robot(model, chain);
  ASSERT_EQ(robot.left_out.size(), 1u);
  EXPECT_EQ(robot.left_out[0].name, "finger");
  EXPECT_EQ(robot.left_out[0].mass, 0.25);
  EXPECT_THAT(robot.text, HasSubstr("'finger' (0.25 kg)"));
  ASSERT_EQ(robot.drives.size(), 1u);
  const Robot read_again = imported(model, chain);
  const Posture at =
      posture_from_joints(read_again.manipulator, {{"one", 1.9198621771937625}}).posture;
  EXPECT_EQ(beyond_range(read_again.manipulator, at), "");
  EXPECT_LT(
      spatial::pose_difference(
          at.platform, Pose::rotation(spatial::exp_rotation(Vector3(0, 0, 2.4198621771937625))))
          .norm(),
      1e-12);
}

TEST_F(Urdf, WhatIsMissingIsListed) {
  const RobotDescription model = read(two_links("revolute"));
  const ImportedRobot robot = import_robot(model, find_chain(model, "", ""));
  ASSERT_EQ(robot.missing.size(), 2u);
  EXPECT_EQ(robot.missing[0].key, "actuator j");
  EXPECT_EQ(robot.missing[1].key, "links.b");
}

TEST_F(Urdf, NamesCannotBreakTheRobotFile) {
  const RobotDescription model = read(
      "<robot name='a &quot;b&quot; \\'><link name='x: [y'/><link "
      "name='#z&#10;w'><visual><geometry>"
      "<mesh filename='a&#10;b: c'/></geometry></visual></link><joint name='}{' type='revolute'>"
      "<parent link='x: [y'/><child link='#z&#10;w'/></joint></robot>");
  EXPECT_EQ(imported(model, find_chain(model, "", "")).name, "a \"b\" \\");
}

TEST_F(Urdf, BrokenFilesAreNamedWithTheirLine) {
  expect_refused("<robot name='r'>\n<link name='a'>\n", "robot.urdf:");
  expect_refused("<sdf/>", "no <robot> element");
  expect_refused("<robot name='r'/>", "no links");
  expect_refused("<robot name='r'>\n<xacro:macro/>\n</robot>", "robot.urdf:2: <xacro:macro>");
  expect_refused("<robot name='r'>\n<link/>\n</robot>", "'name' is missing");
  expect_refused("<robot name='r'><link name='a'/>\n<link name='a'/></robot>", "robot.urdf:2: a");
  expect_refused(two_links("floating"), "a floating joint cannot");
  expect_refused(two_links("revolutee"), "Did you mean 'revolute'?");
  expect_refused(two_links("revolute", "<origin xyz='1 2'/>"), "\"1 2\" is not 3 finite numbers");
  expect_refused(two_links("revolute", "<origin xyz='1 2 3 4'/>"), "is not 3 finite");
  expect_refused(two_links("revolute", "<origin xyz='1 2 nan'/>"), "is not 3 finite");
  expect_refused(two_links("revolute", "<axis xyz='-1e308 1 0'/>"), "is not 3 finite");
  expect_refused(two_links("revolute", "<axis xyz='0 0 0'/>"), "the axis has no length");
  expect_refused(two_links("revolute", "<limit lower='2' upper='1'/>"), "lower is above upper");
  expect_refused(two_links("revolute", "<mimic joint='k'/>"), "it mimics 'k'");
  expect_refused(two_links("fixed"), "no joint moves");
  expect_refused(
      "<robot name='r'><link name='a'/><joint name='j' type='fixed'><parent link='a'/>"
      "<child link='q'/></joint></robot>",
      "there is no link 'q'");
}

// Whatever the chain meets first, the circle alone is named, at its first joint from there.
TEST_F(Urdf, JointsThatMimicEachOtherInACircleAreNamed) {
  const auto chain = [](const std::vector<std::string>& mimicked) {
    std::string text = "<robot name='r'>\n<link name='l0'/>\n";
    for (std::size_t j = 0; j < mimicked.size(); ++j)
      text += fmt::format(
          "<link name='l{1}'/><joint name='j{0}' type='continuous'><parent link='l{0}'/><child "
          "link='l{1}'/><mimic joint='{2}'/></joint>\n",
          j, j + 1, mimicked[j]);
    return text + "</robot>\n";
  };
  expect_refused(chain({"j1", "j0"}),
                 "robot.urdf:3: j0: joints mimic each other in a circle, so that none leads: 'j0', "
                 "'j1' and 'j0' again");
  expect_refused(chain({"j1", "j2", "j3", "j1"}),
                 "robot.urdf:4: j1: joints mimic each other in a circle, so that none leads: 'j1', "
                 "'j2', 'j3' and 'j1' again");
  expect_refused(chain({"j1", "j1"}), "robot.urdf:4: j1: it mimics itself");
}

TEST_F(Urdf, LoopsAndBranchesAreRefusedWithTheirLinks) {
  const std::string loop =
      "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent "
      "link='a'/><child link='b'/></joint><joint name='k' type='fixed'><parent link='b'/><child "
      "link='a'/></joint></robot>";
  expect_refused(loop, "form a loop");
  const RobotDescription model = read(loop);
  EXPECT_EQ(find_chain(model, "a", "b").joints.size(), 1u);
  const RobotDescription arm =
      read_urdf(std::string(KINETOSTAT_SOURCE_DIR) + "/data/urdf/six_axis.urdf");
  EXPECT_THROW(find_chain(arm, "", ""), common::InputError);
  EXPECT_THROW(find_chain(arm, "wrist_1", "forearm"), common::InputError);
  EXPECT_THROW(find_chain(arm, "wrist_9", ""), common::InputError);
}

}  // namespace
}  // namespace kinetostat::vjm::urdf_test
