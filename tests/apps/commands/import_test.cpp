// kinetostat import as its users meet it.
#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::import_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

TEST(ImportCommand, WritesARobotFileAndListsWhatIsMissing) {
  const Outcome outcome =
      kinetostat("import data/urdf/six_axis.urdf --tip flange -o imported.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("actuator joint_1"));
  EXPECT_THAT(outcome.out, HasSubstr("'kinetostat identify' on package://six_axis/meshes/forearm"));
  EXPECT_EQ(kinetostat("stiffness imported.yaml").code, 0);
  // With one stiffness filled in the arm yields about that joint.
  std::string text = io::read_text(working_folder() / "imported.yaml");
  const std::string joint = "{name: joint_1, axis: Rz, range: [-3.05, 3.05]}";
  const std::size_t at = text.find(joint);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, joint.size(), "{name: joint_1, axis: Rz, stiffness: 1.0e5 N m/rad}");
  io::write_atomically(working_folder() / "filled.yaml", text);
  const Outcome moved = kinetostat("deflect filled.yaml --wrench 0,0,0,0,0,100");
  EXPECT_EQ(moved.code, 0) << moved.err;
}

// One stiffness for all drives, or one for each, is what the robot file has; only links are
// missing.
TEST(ImportCommand, TakesTheStiffnessOfDrives) {
  const std::string import = "import data/urdf/six_axis.urdf --tip flange -o arm.yaml ";
  const Outcome all = kinetostat(import + "--joint-stiffness '5e4 N m/rad'");
  ASSERT_EQ(all.code, 0) << all.err;
  EXPECT_THAT(all.out, Not(HasSubstr("actuator joint_1")));
  EXPECT_THAT(all.out, HasSubstr("links.forearm"));
  const auto turn = [] {
    const Outcome moved = kinetostat("deflect arm.yaml --wrench 0,0,0,0,0,100 --json turned.json");
    EXPECT_EQ(moved.code, 0) << moved.err;
    const io::Json turned = io::Json::parse(io::read_text(working_folder() / "turned.json"));
    return turned.at("equilibrium").at("displacement").at("rotation").at(2).get<double>();
  };
  const double soft = turn();
  ASSERT_EQ(kinetostat(import + "--joint-stiffness 1e5").code, 0);
  EXPECT_NEAR(turn() / soft, 0.5, 0.01);  // links are rigid
  ASSERT_EQ(kinetostat(import + "--joint-stiffness 1e5,2e5,3e5,4e4,5e4,6e4").code, 0);
  const std::string text = io::read_text(working_folder() / "arm.yaml");
  EXPECT_THAT(text, HasSubstr("joint_4, axis:"));
  EXPECT_THAT(text, HasSubstr("stiffness: 40000 N m/rad"));
  const Outcome few = kinetostat(import + "--joint-stiffness 1e5,2e5");
  EXPECT_EQ(few.code, 2);
  EXPECT_THAT(few.err, HasSubstr("2 values for 6 drives"));
  EXPECT_EQ(kinetostat(import + "--joint-stiffness 0").code, 2);
  EXPECT_EQ(kinetostat(import + "--joint-stiffness 5e4N/m").code, 2);
}

// By name for some, by effort for the others: what a drive bears at its limit over what it yields.
TEST(ImportCommand, TakesTheStiffnessOfSomeDrivesByNameAndOfOthersByEffort) {
  const std::string import = "import data/urdf/six_axis.urdf --tip flange -o effort.yaml ";
  const Outcome outcome =
      kinetostat(import + "--joint-stiffness joint_3=7e4 --joint-stiffness-by-effort '5 mrad'");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string text = io::read_text(working_folder() / "effort.yaml");
  EXPECT_THAT(text, HasSubstr("# Stiffness of drives by effort"));
  EXPECT_THAT(text, ContainsRegex("name: joint_1, .*stiffness: 60000 N m/rad"));  // 300 N m
  EXPECT_THAT(text, ContainsRegex("name: joint_3, .*stiffness: 70000 N m/rad"));
  EXPECT_EQ(kinetostat("stiffness effort.yaml").code, 0);
  const Outcome misspelt = kinetostat(import + "--joint-stiffness joint_9=7e4");
  EXPECT_EQ(misspelt.code, 2);
  EXPECT_THAT(misspelt.err, HasSubstr("there is no drive 'joint_9'"));
  EXPECT_EQ(kinetostat(import + "--joint-stiffness-by-effort '0 mrad'").code, 2);
  EXPECT_THAT(kinetostat(import + "--joint-stiffness-by-effort 5").err,
              HasSubstr("'5' has no unit. Give '5 mrad' for drives that turn"));
  EXPECT_THAT(kinetostat(import + "--joint-stiffness-by-effort '5 mm'").err,
              HasSubstr("which turns. Give an angle"));
}

// A slide on a joint that turns and has a spring of its own.
constexpr char crane[] = R"(<robot name="crane">
  <link name="base"/><link name="jib"/><link name="trolley"/>
  <joint name="swing" type="revolute"><parent link="base"/><child link="jib"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="200" velocity="1"/></joint>
  <joint name="run" type="prismatic"><parent link="jib"/><child link="trolley"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="300" velocity="1"/></joint>
  <gazebo reference="swing"><springStiffness>12345</springStiffness></gazebo>
</robot>
)";

TEST(ImportCommand, GuessesNoStiffnessThatIsKnownOrOfAnotherSort) {
  io::write_atomically(working_folder() / "crane.urdf", crane);
  const std::string import = "import crane.urdf -o crane.yaml ";
  const Outcome guessed = kinetostat(import + "--joint-stiffness-by-effort '5 mrad,0.1 mm'");
  ASSERT_EQ(guessed.code, 0) << guessed.err;
  const std::string text = io::read_text(working_folder() / "crane.yaml");
  EXPECT_THAT(text, ContainsRegex("name: swing, .*stiffness: 12345 N m/rad"));
  EXPECT_THAT(text, ContainsRegex("name: run, .*stiffness: 3000000 N/m"));
  EXPECT_THAT(guessed.err, Not(HasSubstr("slides")));
  const Outcome refused = kinetostat(import + "--joint-stiffness '5e4 N m/rad'");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("'swing', which turns, and of 'run', which slides"));
  const Outcome doubted = kinetostat(import + "--joint-stiffness 5e4");
  ASSERT_EQ(doubted.code, 0) << doubted.err;
  EXPECT_THAT(doubted.err, HasSubstr("as so many N/m for 'run', which slides"));
  EXPECT_THAT(io::read_text(working_folder() / "crane.yaml"), HasSubstr("which slides"));
  const Outcome empty = kinetostat(import + "--joint-stiffness ''");
  EXPECT_EQ(empty.code, 2);
  EXPECT_THAT(empty.err, HasSubstr("--joint-stiffness: the value is empty"));
}

// A bar along x, in the unit of the file; without its end face it is open there.
std::string bar_stl(double from, double to, double y, double z, bool end_face = true) {
  constexpr int pieces = 12;
  std::string text = "solid bar\n";
  const auto corner = [&](int piece, int i) {
    const int at = piece + (i & 1);
    return fmt::format("vertex {} {} {}\n", from + (to - from) * at / pieces,
                       i & 2 ? y / 2 : -y / 2, i & 4 ? z / 2 : -z / 2);
  };
  const auto add = [&](int piece, const std::array<int, 4>& s) {
    for (const auto& t : {std::array{s[0], s[1], s[2]}, std::array{s[0], s[2], s[3]}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int i : t) text += corner(piece, i);
      text += "endloop\nendfacet\n";
    }
  };
  for (int piece = 0; piece < pieces; ++piece)
    for (const std::array<int, 4>& side :
         {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}})
      add(piece, side);
  add(0, {0, 4, 6, 2});
  if (end_face) add(pieces - 1, {1, 3, 7, 5});
  return text + "endsolid bar\n";
}

// Two bars in a row, joints about their axis: one mesh in metres, one in millimetres along another
// axis; a third link whose mesh is nowhere.
void write_robot_of_bars(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "parts" / "meshes");
  io::write_atomically(folder / "parts" / "meshes" / "upper.stl", bar_stl(0, 0.3, 0.04, 0.06));
  io::write_atomically(folder / "parts" / "meshes" / "fore.stl", bar_stl(0, 300, 40, 60));
  io::write_atomically(
      folder / "bars.urdf",
      "<robot name='bars'><link name='base'/><link name='upper'><inertial><origin xyz='.15 0 0'/>"
      "<mass value='1.9'/><inertia ixx='.001' ixy='0' ixz='0' iyy='.015' iyz='0' izz='.0145'/>"
      "</inertial><visual><geometry><mesh filename='package://bar_parts/meshes/upper.stl'/>"
      "</geometry></visual></link><link name='fore'><visual><origin xyz='0 0 0' rpy='0 0 "
      "-1.5707963267948966'/><geometry><mesh filename='package://bar_parts/meshes/fore.stl' "
      "scale='.001 .001 .001'/></geometry></visual></link><link name='hand'><visual><geometry>"
      "<mesh filename='package://other/hand.stl'/></geometry></visual></link><joint name='one' "
      "type='continuous'><parent link='base'/><child link='upper'/><axis xyz='1 0 0'/></joint>"
      "<joint name='two' type='continuous'><parent link='upper'/><child link='fore'/><origin "
      "xyz='.3 0 0' rpy='0 0 1.5707963267948966'/><axis xyz='0 -1 0'/></joint><joint name='three' "
      "type='continuous'><parent link='fore'/><child link='hand'/><origin xyz='0 -.3 0'/><axis "
      "xyz='0 1 0'/></joint></robot>");
}

void change_robot_of_bars(const std::string& old, const std::string& now) {
  std::string text = io::read_text(working_folder() / "bars.urdf");
  const std::size_t at = text.find(old);
  ASSERT_NE(at, std::string::npos) << old;
  io::write_atomically(working_folder() / "bars.urdf", text.replace(at, old.size(), now));
}

// Where the tool goes along an axis per newton: the difference of two loads, for the weight is in
// the file.
double yields(const std::string& axis, std::size_t number, const std::string& robot = "bars") {
  const auto moved = [&](const std::string& sign) {
    std::string wrench = "0,0,0";
    wrench.replace(2 * number, 1, sign + "100");
    EXPECT_EQ(
        kinetostat("deflect " + robot + ".yaml --wrench=" + wrench + " --json bars.json").code, 0)
        << axis;
    const io::Json found = io::read_json(working_folder() / "bars.json");
    return found.at("equilibrium").at("displacement").at("translation").at(number).get<double>();
  };
  return (moved("") - moved("-")) / 200;
}

// From URDF and meshes to a map in two commands. The compliance is that of the bars as one
// cantilever.
TEST(ImportCommand, IdentifiesLinksFromTheirMeshes) {
  write_robot_of_bars(working_folder());
  const Outcome outcome = kinetostat(
      "import bars.urdf --package bar_parts=parts --identify --material aluminium --accuracy '2 %' "
      "--joint-stiffness 5e4 -o bars.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("upper: held at the flat face of 24 cm^2"));
  EXPECT_THAT(outcome.out, HasSubstr("links.hand"));
  EXPECT_THAT(outcome.out, HasSubstr("its package is not known"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("links.fore")));
  const Outcome map = kinetostat("map bars.yaml --grid x=0.6,y=0,z=0 --index weakest-translation");
  EXPECT_EQ(map.code, 0) << map.err;
  const double e = 70e9, g = e / 2.66, length = 0.6, area = 0.04 * 0.06;
  const auto cantilever = [&](double moment) {
    return length * length * length / (3 * e * moment) + 1.2 * length / (g * area);
  };
  const double y = yields("y", 1), z = yields("z", 2);
  EXPECT_NEAR(y, cantilever(0.06 * std::pow(0.04, 3) / 12), 0.03 * y);
  EXPECT_NEAR(z, cantilever(0.04 * std::pow(0.06, 3) / 12), 0.03 * z);
  EXPECT_EQ(kinetostat("modes bars.yaml").code, 0);  // masses and inertia are kept
}

// Meshes for pictures: a shell that sticks in another one, open where it does, of another file, is
// the same bar.
TEST(ImportCommand, MakesOneSolidOfShellsThatStickInEachOther) {
#ifndef KINETOSTAT_HAS_CGAL
  GTEST_SKIP() << "built without CGAL";
#endif
  write_robot_of_bars(working_folder());
  const std::string import =
      "import bars.urdf --package bar_parts=parts --identify --material aluminium --accuracy '2 %' "
      "--joint-stiffness 5e4 -o ";
  ASSERT_EQ(kinetostat(import + "whole.yaml").code, 0);
  const std::filesystem::path meshes = working_folder() / "parts/meshes";
  io::write_atomically(meshes / "upper.stl", bar_stl(0, 0.19, 0.04, 0.06, false));
  io::write_atomically(meshes / "end.stl", bar_stl(-0.15, 0, 0.04, 0.06));
  change_robot_of_bars(
      "<visual>",
      "<visual><origin xyz='.3 0 0'/><geometry><mesh filename='package://bar_parts/meshes/"
      "end.stl'/></geometry></visual><visual>");
  const Outcome outcome = kinetostat(import + "shells.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("upper: held at the flat face of 24 cm.2[^:]*repaired"));
  for (const auto& [axis, number] : {std::pair("y", 1u), std::pair("z", 2u)}) {
    const double whole = yields(axis, number, "whole");
    EXPECT_NEAR(yields(axis, number, "shells"), whole, 0.02 * whole) << axis;
  }
}

// The same bars as boxes that the description gives by numbers.
TEST(ImportCommand, IdentifiesLinksFromTheirPrimitiveShapes) {
  write_robot_of_bars(working_folder());
  change_robot_of_bars("<geometry><mesh filename='package://bar_parts/meshes/upper.stl'/>",
                       "<origin xyz='.15 0 0'/><geometry><box size='.3 .04 .06'/>");
  change_robot_of_bars(
      "<origin xyz='0 0 0' rpy='0 0 -1.5707963267948966'/><geometry><mesh "
      "filename='package://bar_parts/meshes/fore.stl' scale='.001 .001 .001'/>",
      "<origin xyz='0 -.15 0'/><geometry><box size='.04 .3 .06'/>");
  change_robot_of_bars("<mesh filename='package://other/hand.stl'/>", "<sphere radius='0'/>");
  change_robot_of_bars("<mass value='1.9'/>", "<mass value='.972'/>");
  const Outcome outcome = kinetostat(
      "import bars.urdf --identify --material aluminium --accuracy '2 %' --joint-stiffness 5e4 "
      "-o boxes.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("its shape is a box"));
  EXPECT_THAT(outcome.out, HasSubstr("1.94 kg"));  // 2700 kg/m^3
  EXPECT_THAT(outcome.out, ContainsRegex("a tube of[^:]*75 %"));
  EXPECT_THAT(outcome.out, HasSubstr("the description gives it no shape"));  // to the hand
  const double e = 70e9, g = e / 2.66, length = 0.6, area = 0.04 * 0.06;
  const double moment = 0.06 * std::pow(0.04, 3) / 12;
  const double exact = length * length * length / (3 * e * moment) + 1.2 * length / (g * area);
  EXPECT_NEAR(yields("y", 1, "boxes"), exact, 0.03 * exact);
}

Outcome import_bars() {
  return kinetostat(
      "import bars.urdf --package bar_parts=parts --identify --material aluminium "
      "--joint-stiffness 5e4 -o bars.yaml");
}

// No face lies about an axis beside the bar's own: what is near the joint holds it, and that is
// said.
TEST(ImportCommand, HoldsALinkNearItsJointWhereNoFaceLiesAboutTheAxis) {
  write_robot_of_bars(working_folder());
  change_robot_of_bars("<axis xyz='1 0 0'/>", "<axis xyz='1 1 0.5'/>");
  const Outcome outcome = import_bars();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("as no face lies about that axis"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("links.upper")));
}

// Joints across a long box, one of them far from its edges, where a side is two facets: it bends
// as a cantilever between them, but for what is held.
TEST(ImportCommand, FindsWhatIsNearAJointInTheMiddleOfALargeFace) {
  io::write_atomically(
      working_folder() / "long.urdf",
      "<robot name='long'><link name='base'/><link name='beam'><visual><origin xyz='.4 0 0'/>"
      "<geometry><box size='1 .06 .04'/></geometry></visual></link><link name='end'/><joint "
      "name='one' type='continuous'><parent link='base'/><child link='beam'/><axis xyz='0 1 0'/>"
      "</joint><joint name='two' type='continuous'><parent link='beam'/><child link='end'/><origin "
      "xyz='.6 0 0'/><axis xyz='0 1 0'/></joint></robot>");
  const Outcome outcome = kinetostat(
      "import long.urdf --identify --material aluminium --joint-stiffness 1e9 -o long.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, Not(HasSubstr("links.beam")));
  const double bend = std::pow(0.6, 3) / (3 * 70e9 * 0.06 * std::pow(0.04, 3) / 12);
  const double found = yields("z", 2, "long");
  EXPECT_GT(found, 0.6 * bend);
  EXPECT_LT(found, 1.1 * bend);
}

TEST(ImportCommand, SaysThatACollisionShapeStandsForAMeshThatIsNotThere) {
  write_robot_of_bars(working_folder());
  change_robot_of_bars(
      "package://bar_parts/meshes/upper.stl'/></geometry></visual>",
      "package://other/upper.stl'/></geometry></visual><collision><origin xyz='.15 0 0'/>"
      "<geometry><box size='.3 .04 .06'/></geometry></collision>");
  const Outcome outcome = import_bars();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("upper: held[^:]*its shape is[^:]*instead[^:]*upper.stl"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("links.upper")));
}

TEST(ImportCommand, TakesNoMeshInMillimetresForOneInMetres) {
  write_robot_of_bars(working_folder());
  change_robot_of_bars(" scale='.001 .001 .001'", "");
  const Outcome outcome = import_bars();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("links.fore"));
  EXPECT_THAT(outcome.out, HasSubstr("a mesh in millimetres needs a scale of 0.001"));
}

// A rod of 0.2 m at the first of two joints, so far apart.
std::string rod_robot(double apart, const char* rod) {
  return fmt::format(
      "<robot name='rod'><link name='base'/><link name='rod'><visual><origin xyz='0 0 .1'/>"
      "<geometry>{}</geometry></visual></link><link name='end'/><joint name='one' "
      "type='continuous'><parent link='base'/><child link='rod'/><axis xyz='0 0 1'/></joint><joint "
      "name='two' type='continuous'><parent link='rod'/><child link='end'/><origin xyz='0 0 {}'/>"
      "<axis xyz='0 0 1'/></joint></robot>",
      rod, apart);
}

TEST(ImportCommand, SaysHowFarAShapeEndsFromAJoint) {
  const auto import = [](double apart, const char* rod) {
    io::write_atomically(working_folder() / "rod.urdf", rod_robot(apart, rod));
    return kinetostat("import rod.urdf --identify --material steel --accuracy '20 %' -o rod.yaml");
  };
  constexpr char rod[] = "<cylinder radius='.03' length='.2'/>";
  const Outcome whole = import(0.2, rod);
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_THAT(whole.err, Not(HasSubstr("its shape ends")));
  const Outcome half = import(1, rod);
  ASSERT_EQ(half.code, 0) << half.err;
  EXPECT_THAT(half.err,
              HasSubstr("warning: rod: its shape ends 800 mm from the frame of the next"));
  EXPECT_THAT(half.out, ContainsRegex("its[ \n]+shape[ \n]+ends[ \n]+800[ \n]+mm"));
  const Outcome ball = import(1, "<sphere radius='.1'/>");
  EXPECT_THAT(ball.err, ContainsRegex("its shape ends (799|80[0-9])[0-9.]* mm"));
  EXPECT_THAT(ball.out, Not(HasSubstr("mm of that of the next")));
  const Outcome tiny = import(100, rod);
  EXPECT_THAT(tiny.out, ContainsRegex("links.rod.*its unit, or its scale"));
}

TEST(ImportCommand, RefusesToIdentifyWithoutMaterialOrPlace) {
  write_robot_of_bars(working_folder());
  const Outcome bare = kinetostat("import bars.urdf --identify -o none.yaml");
  EXPECT_EQ(bare.code, 2);
  EXPECT_THAT(bare.err, HasSubstr("--material aluminium"));
  EXPECT_EQ(kinetostat("import bars.urdf --identify --material steel").code, 2);
  EXPECT_EQ(kinetostat("import bars.urdf --identify --material wood -o none.yaml").code, 2);
  EXPECT_EQ(kinetostat("import bars.urdf --package parts -o none.yaml").code, 2);
  const auto refused = [](const std::string& options, const char* why) {
    const Outcome outcome = kinetostat("import bars.urdf -o none.yaml " + options);
    EXPECT_EQ(outcome.code, 2) << options;
    EXPECT_THAT(outcome.err, HasSubstr(why)) << options;
    EXPECT_FALSE(std::filesystem::exists(working_folder() / "none.yaml")) << options;
  };
  refused("--package bar_parts=/nowhere", "there is no folder '/nowhere'");
  refused("--identify --material '{E: 70, nu: 0.3}'", "--material: '70' has no unit");
  refused("--identify --material '{E: 70 GPa, nu: 0.7}'", "--material: ");
  refused("--identify --material steel --accuracy 80", "--accuracy: '80 %' is not between");
  refused("--material steel", "--identify");
  refused("--accuracy '2 %'", "--identify");
}

TEST(ImportCommand, ReadsOtherFormats) {
  for (const std::string file : {"data/urdf/scara.sdf", "data/urdf/arm.xml", "data/urdf/dh.yaml"}) {
    const Outcome outcome = kinetostat("import " + file + " --joint-stiffness 5e4 -o other.yaml");
    EXPECT_EQ(outcome.code, 0) << file << outcome.err;
    EXPECT_EQ(kinetostat("stiffness other.yaml").code, 0) << file;
  }
  io::write_atomically(working_folder() / "dh.csv",
                       "convention,name,type,theta [deg],d [mm],a [mm],alpha [deg],stiffness\n"
                       "standard,q1,revolute,20,400,180,-90,1e5 N m/rad\n"
                       "standard,q2,,-90,,600,,2e5 N m/rad\n");
  EXPECT_EQ(kinetostat("import dh.csv --joint-stiffness 5e4 -o other.yaml").code, 0);
  EXPECT_EQ(kinetostat("stiffness other.yaml").code, 0);
  const Outcome robot = kinetostat("import data/robots/six_axis.yaml");
  EXPECT_EQ(robot.code, 3);
}

// The frame of the tool of an industrial robot in ROS, where other frames end as well.
TEST(ImportCommand, TakesTool0ForTheTip) {
  std::string text = io::read_text(std::string(KINETOSTAT_SOURCE_DIR) + "/data/urdf/six_axis.urdf");
  for (std::size_t at = 0; (at = text.find("\"flange\"", at)) != std::string::npos;)
    text.replace(at, 8, "\"tool0\"");
  io::write_atomically(working_folder() / "tool0.urdf", text);
  const Outcome outcome = kinetostat("import tool0.urdf --joint-stiffness 5e4 -o tool0.yaml");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("to 'tool0'"));
}

TEST(ImportCommand, MistakesAreNamedWithTheirPlace) {
  const Outcome branches = kinetostat("import data/urdf/six_axis.urdf");
  EXPECT_EQ(branches.code, 3);
  EXPECT_THAT(branches.err, HasSubstr("several last links: camera_bracket, flange"));
  const Outcome misspelt = kinetostat("import data/urdf/six_axis.urdf --tip flang");
  EXPECT_EQ(misspelt.code, 3);
  EXPECT_THAT(misspelt.err, HasSubstr("Did you mean 'flange'?"));
  EXPECT_EQ(kinetostat("import nowhere.urdf").code, 3);
  io::write_atomically(working_folder() / "cut.urdf", "<robot name='r'>\n<link name='a'\n");
  const Outcome cut = kinetostat("import cut.urdf");
  EXPECT_EQ(cut.code, 3);
  EXPECT_THAT(cut.err, HasSubstr("cut.urdf:"));
}

}  // namespace
}  // namespace kinetostat::import_test
