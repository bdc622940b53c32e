// Descriptions of robots in formats other than URDF, by kinematics written down by hand.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/exchange/description_file.h"
#include "kinetostat/vjm/exchange/robot_import.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

#include "support/temporary_folder.h"

namespace kinetostat::vjm::description_test {
namespace {

using spatial::Pose;
using spatial::Vector3;
using testing::HasSubstr;

Pose turn(const Vector3& axis, double angle, const Vector3& at = Vector3::Zero()) {
  return Pose::translation(at) * Pose::rotation(spatial::exp_rotation(angle * axis.normalized()));
}
Pose shift(double x, double y, double z) { return Pose::translation({x, y, z}); }

class Description : public testing::Test {
 protected:
  test::TemporaryFolder folder;

  RobotDescription read(const std::string& name, const std::string& text) const {
    return read_robot_description(folder.file(name, text));
  }
  // Of a body of an MJCF model with nothing but these geoms; none weighs nothing.
  DescribedInertia of_geoms(const std::string& geoms, const std::string& settings = "") const {
    const RobotDescription robot =
        read("geoms.xml", "<mujoco>" + settings + "<worldbody><body name='one'><joint name='a'/>" +
                              geoms + "</body></worldbody></mujoco>");
    return robot.links.back().inertia.value_or(DescribedInertia());
  }
  Robot imported(const RobotDescription& robot, const std::string& base = "",
                 const std::string& tip = "") const {
    return parse_robot(import_robot(robot, find_chain(robot, base, tip)).text,
                       folder.path() / "robot.yaml");
  }
  void expect_tip(const Robot& robot, const std::map<std::string, double>& joints,
                  const Pose& exact) const {
    const PostureResult result = posture_from_joints(robot.manipulator, joints);
    ASSERT_TRUE(result.reached) << result.reason;
    EXPECT_LT(spatial::pose_difference(result.posture.platform, exact).norm(), 1e-12);
  }
  void expect_refused(const std::string& name, const std::string& text,
                      const std::string& message) const {
    try {
      const RobotDescription robot = read(name, text);
      import_robot(robot, find_chain(robot, "", ""));
      ADD_FAILURE() << "accepted: " << text;
    } catch (const common::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(message));
    }
  }
};

// Degrees, classes of defaults, orientations in four ways, a joint beside the origin of its body,
// two joints of one body, a reference value, a frame between, a site as tool.
TEST_F(Description, OfMjcf) {
  const RobotDescription robot = read("arm.xml", R"(<mujoco model="arm">
  <compiler angle="degree" meshdir="assets"/>
  <option gravity="0 0 -9.5"/>
  <default>
    <default class="arm"><joint axis="0 1 0" range="-90 90"/>
      <default class="slide"><joint type="slide" axis="0 0 1" range="-0.2 0.3" stiffness="2e6"/></default>
    </default>
  </default>
  <asset><mesh name="cover" file="cover.stl" scale="0.001 0.001 0.001"/></asset>
  <worldbody>
    <body name="column" pos="0.1 0.2 0.3" euler="90 0 30" childclass="arm">
      <inertial pos="0.01 0 0" quat="1 1 0 0" mass="4" diaginertia="0.1 0.2 0.25"/>
      <joint name="a" pos="0.05 0 0.1"/>
      <joint name="b" axis="1 0 0" ref="10"/>
      <geom type="mesh" mesh="cover" pos="0 0 0.2"/>
      <frame pos="0 0 0.5" axisangle="0 0 1 45">
        <body name="sled" xyaxes="0 1 0 -1 0 0">
          <inertial pos="0 0 0" mass="2" fullinertia="0.1 0.1 0.1 0.01 0 0"/>
          <joint name="c" class="slide"/>
          <site name="tool" pos="0 0 0.4" zaxis="1 0 0"/>
        </body>
      </frame>
    </body>
  </worldbody>
  <actuator><motor joint="a" gear="100" forcerange="-2 2"/></actuator>
</mujoco>
)");
  EXPECT_EQ(robot.format, "MJCF");
  const ImportedRobot text = import_robot(robot, find_chain(robot, "", "tool"));
  EXPECT_EQ(find_chain(robot, "", "").tip, "tool");  // by the name of the site
  ASSERT_EQ(text.drives.size(), 3u);
  EXPECT_EQ(text.drives[0].effort, 200);
  EXPECT_EQ(text.drives[2].stiffness, 2e6);
  EXPECT_NEAR((*text.drives[0].limits)[1], M_PI / 2, 1e-15);
  ASSERT_EQ(text.bodies.size(), 3u);
  EXPECT_EQ(text.bodies[1].shapes.at(0).file, "assets/cover.stl");
  const Robot again = imported(robot, "", "tool");
  EXPECT_NEAR(again.manipulator.gravity().z(), -9.5, 1e-12);
  const double a = 0.3, b = -0.4, c = 0.12, deg = M_PI / 180;
  // eulerseq xyz: about the axes that turn along.
  const Pose column =
      shift(0.1, 0.2, 0.3) * turn(Vector3::UnitX(), 90 * deg) * turn(Vector3::UnitZ(), 30 * deg);
  const Pose joints = turn(Vector3::UnitY(), a, {0.05, 0, 0.1}) * shift(-0.05, 0, -0.1) *
                      turn(Vector3::UnitX(), b - 10 * deg);
  const Pose sled = shift(0, 0, 0.5) * turn(Vector3::UnitZ(), 45 * deg) *
                    turn(Vector3::UnitZ(), 90 * deg) * shift(0, 0, c);
  expect_tip(again, {{"a", a}, {"b", b}, {"c", c}},
             column * joints * sled * shift(0, 0, 0.4) * turn(Vector3::UnitY(), 90 * deg));
}

TEST_F(Description, OfMjcfTakesInertiaIntoTheFramesOfLinks) {
  const RobotDescription robot = read("one.xml", R"(<mujoco><worldbody><body name="one">
      <inertial pos="0.01 0 0" quat="1 1 0 0" mass="4" diaginertia="0.1 0.2 0.25"/>
      <joint name="a"/></body></worldbody></mujoco>)");
  const DescribedInertia& inertia = *robot.links.back().inertia;
  // A quarter turn about x exchanges y and z.
  EXPECT_LT((inertia.tensor - Vector3(0.1, 0.25, 0.2).asDiagonal().toDenseMatrix()).norm(), 1e-15);
}

void expect_inertia(const DescribedInertia& found, double mass, const Vector3& center,
                    const Vector3& moments) {
  EXPECT_NEAR(found.mass, mass, 1e-12 * mass);
  EXPECT_LT((found.center - center).norm(), 1e-12);
  EXPECT_LT((found.tensor - moments.asDiagonal().toDenseMatrix()).norm(), 1e-12 * moments.norm());
}

// Half edges, radii and half lengths; 1000 kg/m^3 unless a density or a mass is stated.
TEST_F(Description, OfMjcfWeighsGeomsWhereNoInertiaIsStated) {
  expect_inertia(of_geoms("<geom type='box' size='0.1 0.2 0.3' pos='1 2 3'/>"), 48, {1, 2, 3},
                 {2.08, 1.6, 0.8});
  expect_inertia(of_geoms("<geom type='box' size='0.1 0.2 0.3' euler='0 0 90'/>"), 48, {0, 0, 0},
                 {1.6, 2.08, 0.8});
  const double ball = 500 * 4.0 / 3 * M_PI * 1e-3;
  expect_inertia(of_geoms("<geom size='0.1' density='500'/>"), ball, {0, 0, 0},
                 Vector3::Constant(0.4 * ball * 0.01));
  const double egg = 1000 * 4.0 / 3 * M_PI * 6e-3;
  expect_inertia(of_geoms("<geom type='ellipsoid' size='0.1 0.2 0.3'/>"), egg, {0, 0, 0},
                 egg / 5 * Vector3(0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04));
  expect_inertia(of_geoms("<geom type='cylinder' size='0.05' fromto='0 0 0 0.4 0 0' mass='2'/>"), 2,
                 {0.2, 0, 0}, {0.0025, 2 * 0.1675 / 12, 2 * 0.1675 / 12});
  // Three quarters of a capsule are its cylinder: 2.25 (3 r^2 + l^2) / 12 + 0.75 (2 r^2 / 5 + l^2 /
  // 4 + 3 l r / 8) across, 2.25 r^2 / 2 + 0.75 * 2 r^2 / 5 along.
  expect_inertia(of_geoms("<geom type='capsule' size='0.1 0.2' mass='3' density='9'/>"), 3,
                 {0, 0, 0}, {0.079875, 0.079875, 0.01425});
  // Two balls 1 m apart, in the frame of another element.
  expect_inertia(of_geoms("<frame pos='0 0 2'><geom size='0.1' mass='1' pos='0.5 0 0'/>"
                          "<geom size='0.1' mass='1' pos='-0.5 0 0'/></frame>"),
                 2, {0, 0, 2}, {0.008, 0.508, 0.508});
}

// The attributes `inertiafromgeom` and `inertiagrouprange` of the compiler.
TEST_F(Description, OfMjcfTakesMassesFromWhereItsCompilerDoes) {
  const std::string ball = "<geom size='0.1' mass='7'/>";
  const std::string stated = "<inertial pos='0 0 0' mass='4' diaginertia='1 1 1'/>" + ball;
  const auto compiler = [](const std::string& word) { return "<compiler " + word + "/>"; };
  EXPECT_EQ(of_geoms(stated).mass, 4);
  EXPECT_EQ(of_geoms(stated, compiler("inertiafromgeom='auto'")).mass, 4);
  EXPECT_EQ(of_geoms(stated, compiler("inertiafromgeom='true'")).mass, 7);
  EXPECT_EQ(of_geoms(ball, compiler("inertiafromgeom='false'")).mass, 0);
  const std::string shown = ball + "<geom size='0.1' mass='2' group='3'/>";
  EXPECT_EQ(of_geoms(shown).mass, 9);
  EXPECT_EQ(of_geoms(shown, compiler("inertiagrouprange='0 2'")).mass, 7);
  EXPECT_EQ(of_geoms(shown, compiler("inertiagrouprange='3 3'")).mass, 2);
  EXPECT_EQ(of_geoms(ball + "<geom type='plane' size='1 1 1'/>").mass, 7);
  EXPECT_EQ(of_geoms("<geom size='0.1' mass='0'/>" + ball).mass, 7);
  EXPECT_EQ(of_geoms("<geom size='0.1'/>", "<default><geom mass='5'/></default>").mass, 5);
  EXPECT_EQ(of_geoms("<geom size='0.1'/>", "<default><geom density='0'/></default>").mass, 0);
  expect_refused("wrong.xml", "<mujoco><compiler inertiafromgeom='yes'/><worldbody/></mujoco>",
                 "inertiafromgeom 'yes'");
  expect_refused("light.xml",
                 "<mujoco><worldbody><body name='b'>\n<geom size='1' mass='-1'/></body></worldbody>"
                 "</mujoco>",
                 "light.xml:2");
}

// What a mesh weighs is not known; one without weight beside others does not matter.
TEST_F(Description, OfMjcfSaysWhichMassesItDoesNotKnow) {
  const auto model = [this](const std::string& mesh) {
    return read("mesh.xml",
                "<mujoco><asset><mesh name='m' file='m.stl'/></asset><worldbody>"
                "<body name='one'><joint name='a'/><geom size='0.1' mass='7'/>"
                "<geom type='mesh' mesh='m'" +
                    mesh + "/></body></worldbody></mujoco>");
  };
  const RobotDescription light = model(" mass='0'"), heavy = model("");
  EXPECT_EQ(light.links.back().inertia->mass, 7);
  EXPECT_THAT(light.remarks, testing::ElementsAre(HasSubstr("follow from their geoms")));
  EXPECT_FALSE(heavy.links.back().inertia);
  EXPECT_THAT(heavy.remarks, testing::ElementsAre(HasSubstr("from meshes or shells")));
}

// A robot stands at home with its springs relaxed: where the formats say that they are.
TEST_F(Description, StandsWhereTheSpringsOfJointsAreRelaxed) {
  const RobotDescription mjcf = read("ref.xml", R"(<mujoco><worldbody><body name="one">
      <joint name="a" stiffness="1e4" springref="10"/><joint name="b" stiffness="1e4" ref="20"/>
      <joint name="c" type="slide" stiffness="1e6" springref="0.3" range="-0.1 0.2"/>
      </body></worldbody></mujoco>)");
  const std::string text = import_robot(mjcf, find_chain(mjcf, "", "")).text;
  EXPECT_THAT(text, HasSubstr(fmt::format("name: a, axis: Rz, home: {},", 10 * M_PI / 180)));
  EXPECT_THAT(text, HasSubstr("name: b, axis: Rz, stiffness"));
  EXPECT_THAT(text, HasSubstr("name: c, axis: Tz, range"));
  EXPECT_THAT(text, HasSubstr("the spring of 'c' is relaxed at 0.3 m, beyond its range"));
  const RobotDescription sdf = read("ref.sdf", R"(<sdf version="1.9"><model name="m">
  <link name="base"/><link name="one"/>
  <joint name="a" type="prismatic"><parent>base</parent><child>one</child><axis><xyz>1 0 0</xyz>
    <dynamics><spring_reference>0.25</spring_reference><spring_stiffness>3e4</spring_stiffness></dynamics>
  </axis></joint></model></sdf>)");
  EXPECT_THAT(import_robot(sdf, find_chain(sdf, "", "")).text, HasSubstr("home: 0.25,"));
  // A joint in the place of the one that it follows by -2 and 0.1: springs side by side.
  const RobotDescription urdf = read("ref.urdf", R"(<robot name="r"><link name="base"/>
  <link name="one"/><link name="finger"/>
  <joint name="a" type="continuous"><parent link="base"/><child link="one"/>
    <mimic joint="f" multiplier="-2" offset="0.1"/></joint>
  <joint name="f" type="continuous"><parent link="base"/><child link="finger"/></joint>
  <gazebo reference="a"><springStiffness>100</springStiffness><springReference>0.2</springReference></gazebo>
  <gazebo reference="f"><springStiffness>400</springStiffness><springReference>0.3</springReference></gazebo>
</robot>)");
  // 100 N m/rad relaxed at 0.2, and 400 / 4 at -2 * 0.3 + 0.1.
  const Robot again = imported(urdf, "base", "one");
  EXPECT_NEAR(again.manipulator.chains()[0].coordinates()[0].home, (0.2 - 0.5) / 2, 1e-12);
}

// Poses in other frames, an axis in the model's, a joint beside the frame of its child, a mimic.
TEST_F(Description, OfSdf) {
  const RobotDescription robot = read("arm.sdf", R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 0 -9.7</gravity><model name="arm">
  <frame name="corner" attached_to="base"><pose>0.1 0 0.2 0 0 0.5</pose></frame>
  <link name="base"><pose>0 0 1 0 0 0</pose></link>
  <link name="upper"><pose relative_to="corner">0 0 0.3 0.2 0 0</pose>
    <inertial><pose>0.1 0 0 0 0 1.5707963267948966</pose><mass>5</mass>
      <inertia><ixx>0.1</ixx><ixy>0</ixy><ixz>0</ixz><iyy>0.2</iyy><iyz>0</iyz><izz>0.25</izz></inertia>
    </inertial></link>
  <link name="fore"><pose relative_to="upper">0.5 0 0 0 0.3 0</pose></link>
  <joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="a" type="revolute"><pose>0 0.05 -0.1 0 0 0</pose><parent>base</parent><child>upper</child>
    <axis><xyz expressed_in="__model__">0 0 1</xyz><limit><lower>-1</lower><upper>2</upper><effort>150</effort></limit>
      <dynamics><spring_stiffness>3e4</spring_stiffness></dynamics></axis></joint>
  <joint name="b" type="prismatic"><parent>upper</parent><child>fore</child>
    <axis><xyz>0 1 0</xyz><mimic joint="a"><multiplier>0.1</multiplier><offset>0.02</offset><reference>0.3</reference></mimic></axis></joint>
</model></world></sdf>)");
  EXPECT_EQ(robot.format, "SDF");
  const Robot again = imported(robot);
  EXPECT_NEAR(again.manipulator.gravity().z(), -9.7, 1e-12);
  const Pose base = shift(0, 0, 1);
  const Pose upper = base * shift(0.1, 0, 0.2) * turn(Vector3::UnitZ(), 0.5) * shift(0, 0, 0.3) *
                     turn(Vector3::UnitX(), 0.2);
  const Vector3 anchor = upper * Vector3(0, 0.05, -0.1);
  const double a = 0.7, b = 0.1 * (a - 0.3) + 0.02;
  const Pose exact = turn(Vector3::UnitZ(), a, anchor) * Pose::translation(-anchor) * upper *
                     shift(0.5, 0, 0) * turn(Vector3::UnitY(), 0.3) * shift(0, b, 0);
  expect_tip(again, {{"a", a}}, exact);
  const auto upper_link = std::find_if(robot.links.begin(), robot.links.end(),
                                       [](const DescribedLink& l) { return l.name == "upper"; });
  EXPECT_LT(
      (upper_link->inertia->tensor - Vector3(0.2, 0.1, 0.25).asDiagonal().toDenseMatrix()).norm(),
      1e-15);
}

// As the specification has it, and Gazebo.
TEST_F(Description, LinksOfSdfThatSayNothingOfTheirMassHaveAKilogram) {
  const RobotDescription robot = read("m.sdf", R"(<sdf version="1.9"><model name="r">
    <link name="base"/><link name="a"/>
    <link name="b"><inertial><mass>2</mass></inertial></link>
    <link name="c"><inertial><mass>2</mass><inertia><ixx>3</ixx></inertia></inertial></link>
    <joint name="j" type="revolute"><parent>base</parent><child>a</child><axis><xyz>0 0 1</xyz></axis></joint>
    <joint name="k" type="fixed"><parent>a</parent><child>b</child></joint>
    <joint name="l" type="fixed"><parent>b</parent><child>c</child></joint></model></sdf>)");
  const auto inertia = [&](std::size_t i) { return *robot.links[i].inertia; };
  EXPECT_EQ(inertia(1).mass, 1);
  EXPECT_TRUE(inertia(1).is_assumed);
  for (const std::size_t i : {1, 2}) EXPECT_TRUE(inertia(i).tensor.isIdentity(0));
  EXPECT_EQ(inertia(3).tensor.diagonal(), Vector3(3, 1, 1));
  EXPECT_THAT(import_robot(robot, find_chain(robot, "base", "c")).text,
              HasSubstr("what SDF means where a link says nothing"));
}

// By the attribute `auto` of SDF 1.11; a stated mass scales what the shapes have.
TEST_F(Description, LinksOfSdfMayWeighWhatTheirCollisionsDo) {
  const auto of_link = [this](const std::string& inertial, const std::string& geometry) {
    return read("auto.sdf",
                "<sdf version='1.11'><model name='r'><link name='l'><inertial auto='true'>" +
                    inertial + "</inertial><collision name='a'><pose>1 2 3 0 0 0</pose>" +
                    geometry + "</collision></link></model></sdf>");
  };
  const std::string box = "<geometry><box><size>0.2 0.4 0.6</size></box></geometry>";
  const auto inertia = [&](const std::string& inertial, const std::string& geometry) {
    return *of_link(inertial, geometry).links.back().inertia;
  };
  expect_inertia(inertia("", box), 48, {1, 2, 3}, {2.08, 1.6, 0.8});
  expect_inertia(inertia("<density>500</density>", box), 24, {1, 2, 3}, {1.04, 0.8, 0.4});
  expect_inertia(inertia("<density>9</density>", "<density>500</density>" + box), 24, {1, 2, 3},
                 {1.04, 0.8, 0.4});
  expect_inertia(inertia("<mass>12</mass>", box), 12, {1, 2, 3}, {0.52, 0.4, 0.2});
  const RobotDescription mesh =
      of_link("", "<geometry><mesh><uri>model://a/b.stl</uri></mesh></geometry>");
  EXPECT_FALSE(mesh.links.back().inertia);
  EXPECT_THAT(mesh.remarks, testing::ElementsAre(HasSubstr("computes it from a mesh")));
  expect_refused(
      "empty.sdf",
      "<sdf version='1.11'><model name='r'><link name='l'>\n<inertial auto='true'/></link>"
      "</model></sdf>",
      "empty.sdf:2");
}

// One box, cylinder, capsule and ball in three formats.
TEST_F(Description, TakesPrimitiveShapes) {
  const RobotDescription urdf = read("a.urdf", R"(<robot name="r"><link name="l">
    <visual><origin xyz="1 2 3"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
    <visual><geometry><cylinder radius="0.05" length="0.4"/></geometry></visual>
    <visual><geometry><capsule radius="0.05" length="0.4"/></geometry></visual>
    <visual><geometry><box size="0 0 0"/></geometry></visual>
    <collision><geometry><sphere radius="0.07"/></geometry></collision></link></robot>)");
  const RobotDescription sdf = read("a.sdf", R"(<sdf version="1.9"><model name="r"><link name="l">
    <visual name="a"><pose>1 2 3 0 0 0</pose><geometry><box><size>0.1 0.2 0.3</size></box></geometry></visual>
    <visual name="b"><geometry><cylinder><radius>0.05</radius><length>0.4</length></cylinder></geometry></visual>
    <visual name="c"><geometry><capsule><radius>0.05</radius><length>0.4</length></capsule></geometry></visual>
    <visual name="d"><geometry><plane/></geometry></visual>
    <collision name="e"><geometry><sphere><radius>0.07</radius></sphere></geometry></collision></link></model></sdf>)");
  // Half lengths, a capsule between two points, sizes from a class, and what collides is not drawn.
  const RobotDescription mjcf = read("a.xml", R"(<mujoco>
    <default><default class="seen"><geom contype="0" conaffinity="0" size="0.05 0.2"/></default></default>
    <worldbody><geom type="plane" size="1 1 1"/><body name="l">
    <geom class="seen" type="box" size="0.05 0.1 0.15" pos="1 2 3"/>
    <geom class="seen" type="cylinder"/>
    <geom class="seen" type="capsule" size="0.05" fromto="0 0 -0.2 0 0 0.2"/>
    <geom size="0.07"/></body></worldbody></mujoco>)");
  for (const RobotDescription* robot : {&urdf, &sdf, &mjcf}) {
    const std::vector<DescribedShape>& shapes = robot->links.back().shapes;
    ASSERT_EQ(shapes.size(), 4u) << robot->format;
    EXPECT_LT((shapes[0].solid.edges - Vector3(0.1, 0.2, 0.3)).norm(), 1e-15) << robot->format;
    EXPECT_EQ(shapes[0].pose.position(), Vector3(1, 2, 3)) << robot->format;
    using Kind = PrimitiveSolid::Kind;
    const Kind kinds[] = {Kind::box, Kind::cylinder, Kind::capsule, Kind::capsule};
    const double radii[] = {0, 0.05, 0.05, 0.07}, lengths[] = {0, 0.4, 0.4, 0};
    for (std::size_t s = 0; s < 4; ++s) {
      EXPECT_EQ(shapes[s].solid.kind, kinds[s]) << robot->format << s;
      EXPECT_NEAR(shapes[s].solid.radius, radii[s], 1e-15) << robot->format << s;
      EXPECT_NEAR(shapes[s].solid.length, lengths[s], 1e-15) << robot->format << s;
      EXPECT_EQ(shapes[s].is_collision, s == 3) << robot->format << s;
    }
  }
  expect_refused("b.urdf",
                 "<robot name='r'><link name='l'><visual>\n<geometry><box size='1 2'/></geometry>"
                 "</visual></link></robot>",
                 "b.urdf:2");
}

// Both conventions, as their books multiply them.
TEST_F(Description, OfDenavitAndHartenberg) {
  const std::string joints =
      "joints:\n  - {theta: 10, d: 400, a: 25, alpha: -90, range: [-170, 170], effort: 200 N m}\n"
      "  - {name: slide, type: prismatic, theta: 30, d: 100, a: 315, alpha: 20}\n"
      "  - {theta: -40, d: 50, a: 35, alpha: 70, stiffness: 2.0e4 N m/rad}\n";
  const std::string head =
      "kinetostat: 1\nname: table\nunits: {length: mm, force: N, angle: deg}\n";
  const double deg = M_PI / 180, q1 = 0.3, q2 = 0.07, q3 = -0.6;
  const double theta[] = {10 * deg + q1, 30 * deg, -40 * deg + q3}, d[] = {0.4, 0.1 + q2, 0.05},
               a[] = {0.025, 0.315, 0.035}, alpha[] = {-90 * deg, 20 * deg, 70 * deg};
  Pose standard, modified;
  for (int i = 0; i < 3; ++i) {
    const Pose z = turn(Vector3::UnitZ(), theta[i]) * shift(0, 0, d[i]),
               x = shift(a[i], 0, 0) * turn(Vector3::UnitX(), alpha[i]);
    standard = standard * z * x;
    modified = modified * x * z;
  }
  const std::map<std::string, double> at{{"q1", q1}, {"slide", q2}, {"q3", q3}};
  const RobotDescription one = read("a.yaml", head + "dh: standard\n" + joints);
  expect_tip(imported(one), at, standard);
  EXPECT_EQ(one.joints[0].effort, 200);
  EXPECT_EQ(one.joints[2].stiffness, 2e4);
  expect_tip(imported(read("b.yaml", head + "dh: modified\n" + joints)), at, modified);
  const auto table = [&](const std::string& convention) {
    return read("t.csv",
                "name,type,theta [deg],d [mm],a [mm],alpha [deg],convention\n"
                "q1,revolute,10,400,25,-90," +
                    convention + "\nslide,prismatic,30,100,315,20," + convention +
                    "\nq3,,-40,50,35,70," + convention + "\n");
  };
  expect_tip(imported(table("standard")), at, standard);
  expect_tip(imported(table("modified")), at, modified);
}

// Gravity is that of the world, in axes of whichever link is the base.
TEST_F(Description, TurnsGravityIntoTheBase) {
  const std::string arm = R"(<link name="wall"/><link name="beam"><pose>0 0 0.5 0 0 0</pose></link>
    <joint name="q" type="revolute"><parent>wall</parent><child>beam</child><axis><xyz>0 1 0</xyz></axis></joint>)";
  const double quarter = 1.5707963267948966;
  const auto gravity_of = [&](const std::string& text) {
    return Vector3(imported(read("wall.sdf", text)).manipulator.gravity());
  };
  const Vector3 along_x = 9.8 * Vector3(1, 0, 0);  // pitched by a quarter: down is along its x
  const std::string pitched = fmt::format("<pose>1 2 3 0 {:.16g} 0</pose>", quarter);
  EXPECT_LT((gravity_of("<sdf version='1.9'><world name='w'><model name='m'>" + pitched + arm +
                        "</model></world></sdf>") -
             along_x)
                .norm(),
            1e-12);
  std::string turned_link = arm;
  turned_link.replace(turned_link.find("<link name=\"wall\"/>"), 19,
                      "<link name='wall'>" + pitched + "</link>");
  EXPECT_LT(
      (gravity_of("<sdf version='1.9'><model name='m'>" + turned_link + "</model></sdf>") - along_x)
          .norm(),
      1e-12);
  // A joint to the world: the base is the world, and the model's pose counts.
  const Robot held = imported(read(
      "held.sdf", "<sdf version='1.9'><model name='m'>" + pitched + arm +
                      "<joint name='bolts' type='fixed'><parent>world</parent><child>wall</child>"
                      "</joint></model></sdf>"));
  EXPECT_LT((held.manipulator.gravity() - Vector3(0, 0, -9.8)).norm(), 1e-12);
  expect_tip(held, {}, turn({0, 1, 0}, quarter, {1, 2, 3}) * shift(0, 0, 0.5));
  const RobotDescription urdf = read("wall.urdf", fmt::format(R"(<robot name="wall">
    <link name="room"/><link name="wall"/><link name="beam"/>
    <joint name="mount" type="fixed"><parent link="room"/><child link="wall"/>
      <origin rpy="0 {:.16g} 0"/></joint>
    <joint name="q" type="continuous"><parent link="wall"/><child link="beam"/>
      <axis xyz="0 0 1"/></joint></robot>)",
                                                              quarter));
  EXPECT_LT((imported(urdf).manipulator.gravity() - Vector3(0, 0, -9.80665)).norm(), 1e-12);
  EXPECT_LT((imported(urdf, "wall").manipulator.gravity() - Vector3(9.80665, 0, 0)).norm(), 1e-12);
}

// Until 1.4 axes were those of the model (conversion 1.4 to 1.5 of the specification).
TEST_F(Description, OfOldSdfHasAxesOfTheModel) {
  const std::string model = R"(<model name="m"><link name="a"/>
    <link name="b"><pose>0 0 1 0 1.5707963267948966 0</pose></link>
    <joint name="q" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
    </model></sdf>)";
  const Pose rest = turn({0, 1, 0}, 1.5707963267948966, {0, 0, 1});
  expect_tip(imported(read("old.sdf", "<sdf version='1.4'>" + model)), {{"q", 0.3}},
             shift(0, 0, 1) * turn({0, 0, 1}, 0.3) * shift(0, 0, -1) * rest);
  expect_tip(imported(read("new.sdf", "<sdf version='1.6'>" + model)), {{"q", 0.3}},
             rest * turn({0, 0, 1}, 0.3));
}

// MuJoCo's law y - y0 = a0 + a1 (x - x0) with the reference values of both joints.
TEST_F(Description, OfMjcfKnowsEqualities) {
  const auto text = [](const std::string& equality) {
    return R"(<mujoco><compiler angle="radian"/><worldbody><body name="a">
      <joint name="x" axis="0 0 1" ref="0.4"/>
      <body name="b" pos="1 0 0"><frame pos="0 0.2 0" euler="0 0 1.5707963267948966">
        <joint name="y" axis="1 0 0" ref="-0.5"/></frame></body></body></worldbody><equality>)" +
           equality + "</equality></mujoco>";
  };
  // The joint in the frame turns about the body's y, through (0, 0.2, 0).
  const auto tip = [](double x, double y) {
    return turn({0, 0, 1}, x - 0.4) * shift(1, 0, 0) * turn({0, 1, 0}, y + 0.5);
  };
  expect_tip(imported(read("free.xml", text(""))), {{"x", 0.7}, {"y", 0.1}}, tip(0.7, 0.1));
  const std::string law = "joint1='y' joint2='x' polycoef='0.2 2 0 0 0'/>";
  expect_tip(imported(read("led.xml", text("<joint " + law))), {{"x", 0.7}},
             tip(0.7, -0.5 + 0.2 + 2 * (0.7 - 0.4)));
  expect_tip(imported(read("off.xml", text("<joint active='false' " + law))),
             {{"x", 0.7}, {"y", 0.1}}, tip(0.7, 0.1));
  expect_tip(imported(read("held.xml", text("<joint joint1='y' polycoef='0.3 1 0 0 0'/>"))),
             {{"x", 0.7}}, tip(0.7, -0.2));
  expect_refused("loop.xml", text("<connect body1='a' body2='b' anchor='0 0 0'/>"), "loop");
}

// A scene that includes a robot, which includes its classes of defaults and the body of its hand:
// what is in the files stands where they are included.
TEST_F(Description, OfMjcfReadsWhatItIncludes) {
  const auto part = [this](const std::string& name, const std::string& text) {
    folder.file(name, "<mujocoinclude>\n" + text + "\n</mujocoinclude>");
  };
  part("classes.xml", "<default><joint axis='0 1 0' stiffness='70'/></default>");
  part("hand.xml", "<body name='hand' pos='1 0 0'><joint name='y'/></body>");
  part("arm.xml",
       "<include file='classes.xml'/><worldbody><body name='arm'><joint name='x'/>"
       "<include file='hand.xml'/></body></worldbody>");
  const auto scene = [](const std::string& more) {
    return "<mujoco><option gravity='0 -9 0'/><include file='arm.xml'/>" + more + "</mujoco>";
  };
  const RobotDescription robot = read("scene.xml", scene("<worldbody><light/></worldbody>"));
  EXPECT_EQ(robot.gravity, Vector3(0, -9, 0));
  EXPECT_EQ(robot.joints.back().stiffness, 70);
  expect_tip(imported(robot), {{"x", 0.3}, {"y", 0.4}},
             turn({0, 1, 0}, 0.3) * shift(1, 0, 0) * turn({0, 1, 0}, 0.4));

  expect_refused("scene.xml", scene("<include file='hand.xml'/>"), "hand.xml' is included twice");
  expect_refused("scene.xml", scene("<include file='foot.xml'/>"), "there is no file");
  expect_refused("scene.xml", scene("<include file='" + std::string(5000, 'x') + "'/>"),
                 "there is no file");
  part("arm.xml", "<worldbody><body>\n<freejoint/></body></worldbody>");
  expect_refused("scene.xml", scene(""), "arm.xml:3: <freejoint>");
  part("arm.xml", "<include file='arm.xml'/>");
  expect_refused("scene.xml", scene(""), "arm.xml' is included twice");
}

TEST_F(Description, NamesMistakesWithTheirPlace) {
  expect_refused("a.xml", "<mujoco>\n<worldbody>\n<body><freejoint/></body></worldbody></mujoco>",
                 "a.xml:3: <freejoint>");
  expect_refused("a.xml",
                 "<mujoco><worldbody><body><joint type='ball'/></body></worldbody></mujoco>",
                 "a ball joint");
  expect_refused("a.sdf", "<sdf><model name='m'><joint name='j' type='screw'/></model></sdf>",
                 "a screw joint is not read");
  expect_refused(
      "a.sdf",
      "<sdf><model name='m'><link name='a'><pose relative_to='b'/></link><joint name='j' "
      "type='fixed'><parent>world</parent><child>a</child></joint></model></sdf>",
      "there is no frame 'b'");
  expect_refused("a.sdf",
                 "<sdf><model name='m'><frame name='f'><pose relative_to='g'/></frame><frame "
                 "name='g'><pose relative_to='f'/></frame><link name='a'><pose "
                 "relative_to='f'/></link><joint name='j' type='fixed'><parent>world</parent>"
                 "<child>a</child></joint></model></sdf>",
                 "refers to itself");
  expect_refused("a.sdf", "<sdf><model name='m'><include/></model></sdf>", "nested models");
  expect_refused("a.yaml", "kinetostat: 1\nname: x\n", "no table of Denavit and Hartenberg");
  expect_refused("a.csv", "theta,d,a,alpha\n0,0,0,0\n", "does not say which convention");
  expect_refused("a.csv", "thetta,d,a,alpha,convention\n0,0,0,0,standard\n",
                 "Did you mean 'theta'?");
  expect_refused("a.csv", "theta,d,a,alpha,convention\n0 deg,1,0 mm,0 deg,standard\n", "a.csv:2");
}

// What a YAML table refuses is refused in a CSV table: units of another sort, words for "not
// measured", half a range, what cannot be negative.
TEST_F(Description, TablesOfParametersTakeNothingElseForThem) {
  const auto refused = [this](const std::string& columns, const std::string& cells,
                              const std::string& message) {
    expect_refused("a.csv", "convention," + columns + "\nstandard," + cells + "\n", message);
  };
  refused("a [deg]", "180", "'180 deg' is in rad: expected a length");
  refused("d [N m]", "1", "a.csv:2");
  refused("alpha [mm]", "0", "'0 mm' is in m");
  refused("stiffness [N/mm]", "5", "'5 N/mm' is in");
  refused("d [mm]", "nan", "a.csv:2");
  refused("d [mm]", "-", "a.csv:2");
  refused("d [mm]", "inf", "is no finite number");
  refused("lower [deg]", "-10", "'upper' is empty");
  refused("effort [N m]", "-10", "is not positive");
  EXPECT_EQ(read("a.csv", "convention,d [mm],stiffness\nstandard,,\n").joints[0].stiffness,
            std::nullopt);
}

std::string body_of(const std::string& content) {
  return "<mujoco>\n<worldbody><body name='b'>" + content + "</body></worldbody></mujoco>";
}

TEST_F(Description, OfMjcfRefusesWhatMujocoDoes) {
  const std::string hinge = "<joint name='q'/>";
  expect_refused("a.xml", body_of("<joint type='slid'/>"),
                 "the joint type 'slid' is not known. Did you mean 'slide'?");
  expect_refused("a.xml", body_of("<joint stiffness='-5'/>"), "a stiffness cannot be negative");
  expect_refused("a.xml", body_of(hinge + "<geom type='box'/>"), "a box needs 3 numbers of 'size'");
  expect_refused("a.xml", body_of(hinge + "<geom type='capsule' size='0.1'/>"), "2 numbers");
  expect_refused("a.xml", body_of(hinge + "<geom size='-0.1'/>"), "a sphere needs a number");
  expect_refused("a.xml", body_of(hinge + "<geom type='cone' size='1'/>"), "the type of geom");
  expect_refused("a.xml", "<mujoco><compiler angle='deg'/></mujoco>",
                 "the angle 'deg' is not known");
  expect_refused("a.xml",
                 "<mujoco><default><default class='large'/></default><worldbody>"
                 "<body childclass='larg'><joint/></body></worldbody></mujoco>",
                 "the class of defaults 'larg' is not known. Did you mean 'large'?");
}

TEST_F(Description, OfMjcfSaysWhatOfItsDynamicsIsLeftOut) {
  const auto remarks = read("left_out.xml", R"(<mujoco>
    <default><position kp="300" gear="2"/></default>
    <worldbody><body name="b"><joint name="q" armature="0.1"/><geom size="0.1"/>
      <body><joint name="p" type="slide"/><geom size="0.1"/></body></body></worldbody>
    <tendon><fixed name="belt"/></tendon>
    <actuator><position joint="q"/><motor joint="p"/>
      <general joint="p" biastype="affine" biasprm="0 -40 -1"/></actuator></mujoco>)")
                           .remarks;
  EXPECT_THAT(remarks, testing::Contains(HasSubstr("(armature) of q,")));
  EXPECT_THAT(remarks, testing::Contains(HasSubstr("their springs (belt)")));
  EXPECT_THAT(remarks, testing::Contains(HasSubstr("'q=1200 N m/rad,p=40 N/m'")));
}

TEST_F(Description, OfSdfAndUrdfRefuseWhatNoBodyHas) {
  const auto sdf = [this](const std::string& content, const std::string& message) {
    expect_refused("a.sdf", "<sdf><model name='m'>" + content + "</model></sdf>", message);
  };
  const std::string links = "<link name='a'/><link name='b'/>";
  sdf(links + "<frame name='tool' attached_to='wrist'/>", "attached to 'wrist'");
  sdf(links + "<joint name='q' type='revolut'/>",
      "of 'q' the joint type 'revolut' is not known. Did you mean 'revolute'?");
  sdf("<link name='a'><inertial><mass>1</mass><inertia><ixx>-1</ixx></inertia></inertial></link>",
      "a moment of inertia cannot be negative");
  const auto urdf = [this](const std::string& content, const std::string& message) {
    expect_refused("a.urdf", "<robot name='r'><link name='a'>" + content + "</link></robot>",
                   message);
  };
  urdf("<inertial><mass value='1'/><inertia iyy='1' izz='1'/></inertial>", "'ixx' is missing");
  urdf("<visual><geometry><sphere radius='-1'/></geometry></visual>", "a radius cannot");
  expect_refused("a.urdf", "<robot name='r'><link name='a'></robot>",
                 "an element is not closed, or closed by another name");
  const RobotDescription cone =
      read("cone.urdf",
           "<robot name='r'><link name='a'><visual><geometry><cone/></geometry></visual></link>"
           "</robot>");
  EXPECT_THAT(cone.remarks, testing::ElementsAre(HasSubstr("URDF knows no <cone>")));
  const RobotDescription no_tensor =
      read("m.sdf",
           "<sdf><model name='m'><link "
           "name='a'><inertial><mass>2</mass></inertial></link></model></sdf>");
  EXPECT_THAT(no_tensor.remarks, testing::Contains(HasSubstr("'a' has a mass and no <inertia>")));
}

}  // namespace
}  // namespace kinetostat::vjm::description_test
