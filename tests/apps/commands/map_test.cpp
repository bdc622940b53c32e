// kinetostat map as its users meet it.
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/csv.h"
#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::map_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string orthoglide = "map data/robots/orthoglide.yaml ";
const std::string grid = "--grid x=-60:60:4,y=0:50:3,z=-20:20:2 --index weakest-translation ";

TEST(MapCommand, TableAndGridAreTheSameBytesForAnyNumberOfThreads) {
  for (const char* n : {"1", "2"}) {
    const Outcome outcome = kinetostat(orthoglide + grid + "--out map" + n + ".csv --vtu map" + n +
                                       ".vtu --threads " + n);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("24 poses, 24 reached"));
  }
  for (const char* kind : {".csv", ".vtu"})
    EXPECT_EQ(io::read_text(working_folder() / (std::string("map1") + kind)),
              io::read_text(working_folder() / (std::string("map2") + kind)));
  // Two layers of 3 x 2 x 1 bricks.
  EXPECT_THAT(io::read_text(working_folder() / "map1.vtu"),
              HasSubstr("NumberOfPoints=\"24\" NumberOfCells=\"6\""));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "map1.csv.part"));
}

// Each pose on its own, with what is said of its uncertainty: the bytes of the whole.
TEST(MapCommand, InPartsIsTheMapOfOneRun) {
  const std::string command =
      "map data/robots/gantry.yaml --grid x=0:100:3,y=0:80:3,z=20 --index weakest-translation "
      "--draws 20 ";
  ASSERT_EQ(kinetostat(command + "-o whole.csv").code, 0);
  for (const int i : {3, 1, 4, 2})
    ASSERT_EQ(
        kinetostat(command + fmt::format("--part {}/4 -o map.{}.csv --threads {}", i, i, i % 2 + 1))
            .code,
        0);
  ASSERT_EQ(kinetostat("join map.2.csv map.4.csv map.1.csv map.3.csv -o joined.csv").code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "whole.csv"),
            io::read_text(working_folder() / "joined.csv"));
  EXPECT_EQ(io::read_csv(working_folder() / "joined.csv").rows(), 9u);
  EXPECT_THAT(kinetostat("join map.1.csv map.2.csv map.3.csv").err,
              HasSubstr("row 3 of 9 is in none"));
  ASSERT_EQ(kinetostat(command + "--seed 2 --part 4/4 -o other.csv").code, 0);
  EXPECT_THAT(kinetostat("join map.1.csv other.csv").err, HasSubstr("another table"));
  EXPECT_EQ(kinetostat(command + "--part 1/2").code, 2);             // into no file
  EXPECT_EQ(kinetostat(command + "--part 10/10 -o x.csv").code, 2);  // of nine poses
}

// The loads of a path may all be in the other part: what is asked for is asked of the whole path.
TEST(MapCommand, APartOfAPathMayHaveNoLoad) {
  io::write_atomically(working_folder() / "loads.csv", "x,y,z,fx\n0,0,0,0\n10,0,0,50\n0,10,0,0\n");
  const std::string command =
      "map data/robots/orthoglide.yaml --path loads.csv --index deflection ";
  ASSERT_EQ(kinetostat(command + "-o loads_whole.csv").code, 0);
  for (const int i : {1, 2})
    ASSERT_EQ(kinetostat(command + fmt::format("--part {0}/2 -o loads.{0}.csv", i)).code, 0);
  ASSERT_EQ(kinetostat("join loads.2.csv loads.1.csv -o loads_joined.csv").code, 0);
  EXPECT_EQ(io::read_text(working_folder() / "loads_whole.csv"),
            io::read_text(working_folder() / "loads_joined.csv"));
  const std::string part = io::read_text(working_folder() / "loads.1.csv");
  io::write_atomically(working_folder() / "damaged.csv", part + "7,1,2\n");
  EXPECT_THAT(kinetostat("join damaged.csv loads.2.csv").err,
              HasSubstr("damaged.csv: '7' is none of its rows, 0 to 2"));
  io::write_atomically(working_folder() / "short.csv", part.substr(0, part.rfind(',')) + "\n");
  EXPECT_THAT(kinetostat("join short.csv loads.2.csv").err,
              HasSubstr("short.csv: row 2 has 8 cells, those before have 9"));
  io::write_atomically(working_folder() / "endless.csv",
                       "# map 0 of 9999999999999999999 poses\npose,x\n0,1\n");
  EXPECT_THAT(kinetostat("join endless.csv").err,
              HasSubstr("there are far fewer rows than its 9999999999999999999"));
}

TEST(MapCommand, TakesItsOwnTablesForPaths) {
  const auto same_again = [](const std::string& map, const std::string& poses) {
    ASSERT_EQ(kinetostat(map + poses + "-o own.csv").code, 0);
    const Outcome outcome = kinetostat(map + "--path own.csv -o own_again.csv");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const io::CsvTable one = io::read_csv(working_folder() / "own.csv"),
                       other = io::read_csv(working_folder() / "own_again.csv");
    ASSERT_EQ(one.columns(), other.columns());
    const std::size_t index = one.columns().size() - 1;
    for (std::size_t row = 0; row < one.rows(); ++row)
      EXPECT_NEAR(other.number(row, index), one.number(row, index), 1e-9 * one.number(row, index));
  };
  const std::string index = " --no-uncertainty --index weakest-translation ";
  same_again("map data/robots/orthoglide.yaml" + index, "--grid x=-40:40:3,y=10,z=-20:20:2 ");
  same_again("map data/robots/six_axis.yaml" + index, "--grid q2=-20:20:3,q3=40 ");
}

TEST(MapCommand, SaysThatAPathDoesNotStateACoordinate) {
  io::write_atomically(working_folder() / "flat.csv", "x,y\n10,20\n");
  const std::string map = "map data/robots/orthoglide.yaml --index weakest-translation --path ";
  EXPECT_THAT(kinetostat(map + "flat.csv").err, HasSubstr("flat.csv has no column z: it is 0"));
  io::write_atomically(working_folder() / "solid.csv", "x,y,z\n10,20,0\n");
  EXPECT_THAT(kinetostat(map + "solid.csv").err, testing::Not(HasSubstr("no column")));
}

// The poses that are written, read again as a path, have the values that were promised.
TEST(MapCommand, WritesThePathWithTheTurnsThatItChose) {
  const std::string robot = "map data/robots/six_axis.yaml --index stiffness=1,0,0 ";
  const Outcome outcome =
      kinetostat(robot +
                 "--path data/paths/six_axis_seam.csv --turn x --turn-change 15 "
                 "--threads 2 -o turned.csv --json turned.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("times as large"));
  const io::Json choice = io::read_json(working_folder() / "turned.json").at("choice");
  EXPECT_GT(choice.at("worst"), choice.at("worst_as_given"));
  EXPECT_EQ(choice.at("turns").size(), 11u);
  const io::CsvTable table = io::read_csv(working_folder() / "turned.csv");
  std::string poses = "x,y,z,rx,ry,rz\n";
  for (std::size_t i = 0; i < table.rows(); ++i)
    for (std::size_t k = 0; k < 6; ++k)
      poses += fmt::format("{:.12g}{}", table.number(i, k), k < 5 ? ',' : '\n');
  io::write_atomically(working_folder() / "again.csv", poses);
  ASSERT_EQ(kinetostat(robot + "--path again.csv --json again.json").code, 0);
  const io::Json again = io::read_json(working_folder() / "again.json");
  EXPECT_NEAR(again.at("indices").at(0).at("smallest").get<double>(),
              choice.at("worst").get<double>(), 1e-6 * choice.at("worst").get<double>());
}

TEST(MapCommand, SaysWhatAFreeMotionNeeds) {
  const std::string robot = "map data/robots/six_axis.yaml --index stiffness=1,0,0 ";
  const std::string path = "--path data/paths/six_axis_seam.csv ";
  for (const auto& [options, says] :
       {std::pair(std::string("--grid x=1000,z=900 --turn x"), "Give --path"),
        std::pair(path + "--turn 0,0,0", "has no length"),
        std::pair(path + "--turn x --turn-range 10:5:3", "least value first"),
        std::pair(path + "--turn x --turn-change 0", "above zero"),
        std::pair(path + "--place w=1", "--place")}) {
    const Outcome outcome = kinetostat(robot + options);
    EXPECT_EQ(outcome.code, 2) << options;
    EXPECT_THAT(outcome.err, HasSubstr(says)) << options;
  }
  EXPECT_THAT(kinetostat("map data/robots/six_axis.yaml --index first-frequency --grid x=1000").err,
              HasSubstr("needs masses"));
}

// The poses with the joint that are written, read again as a path, have the values promised.
TEST(MapCommand, WritesThePathWithTheJointThatItChose) {
  const std::string robot = "map data/robots/seven_axis.yaml --index stiffness=0,0,1 ";
  const Outcome outcome =
      kinetostat(robot +
                 "--path data/paths/seven_axis_seam.csv --joint a1 --joint-range -90:90:19 "
                 "--joint-change 30 --threads 2 -o held.csv --json held.json --html held.html");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("times as large"));
  EXPECT_THAT(outcome.out, HasSubstr("with a1 at "));
  EXPECT_THAT(outcome.out, HasSubstr("From pose to pose no joint turns by more than"));
  const io::Json choice = io::read_json(working_folder() / "held.json").at("choice");
  EXPECT_GT(choice.at("worst"), choice.at("worst_as_given"));
  EXPECT_EQ(choice.at("joints").at(0).at("joint"), "arm.a1");
  EXPECT_EQ(choice.at("joints").at(0).at("values").size(), 9u);
  const io::CsvTable table = io::read_csv(working_folder() / "held.csv");
  EXPECT_EQ(table.columns().back(), "a1 [deg]");
  const std::size_t last = table.columns().size() - 1;
  std::string poses = "x,y,z,rx,ry,rz,a1 [deg]\n";
  for (std::size_t i = 0; i < table.rows(); ++i) {
    for (std::size_t k = 0; k < 6; ++k) poses += fmt::format("{:.12g},", table.number(i, k));
    poses += fmt::format("{:.12g}\n", table.number(i, last));
    EXPECT_NEAR(table.number(i, last) * M_PI / 180, choice["joints"][0]["values"][i].get<double>(),
                1e-9);
    if (i > 0) {
      EXPECT_LE(std::abs(table.number(i, last) - table.number(i - 1, last)), 30 + 1e-9);
    }
  }
  io::write_atomically(working_folder() / "held_again.csv", poses);
  ASSERT_EQ(kinetostat(robot + "--path held_again.csv --json held_again.json").code, 0);
  const io::Json again = io::read_json(working_folder() / "held_again.json");
  EXPECT_NEAR(again.at("indices").at(0).at("smallest").get<double>(),
              choice.at("worst").get<double>(), 1e-6 * choice.at("worst").get<double>());
}

TEST(MapCommand, PathMayHoldAJoint) {
  const std::string robot = "map data/robots/seven_axis.yaml --index stiffness=0,0,1 ";
  const auto mapped = [&](const std::string& text) {
    io::write_atomically(working_folder() / "holding.csv", text);
    return kinetostat(robot + "--path holding.csv -o holding_map.csv");
  };
  const auto stiffness = [&](const std::string& text) {
    const Outcome outcome = mapped(text);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return io::read_csv(working_folder() / "holding_map.csv").number(0, 7);
  };
  const double held = stiffness("x,z,ry,a1\n500,400,160,-45\n");
  EXPECT_NEAR(stiffness("x,z,ry,arm.a1 [rad]\n500,400,160,-0.785398163397448\n"), held,
              1e-9 * held);
  EXPECT_GT(std::abs(stiffness("x,z,ry\n500,400,160\n") - held), 0.01 * held);
  EXPECT_THAT(mapped("x,z,ry,a1\n500,400,160,80\n").out, HasSubstr("1 unreachable"));
  for (const auto& [text, says] :
       {std::pair("x,z,ry,arm.a12\n500,400,160,0\n", "Did you mean 'arm.a1'?"),
        std::pair("x,a1,arm.a1\n500,1,1\n", "another column means the same"),
        std::pair("fx\n10\n", "no column states the pose")}) {
    const Outcome outcome = mapped(text);
    EXPECT_EQ(outcome.code, 3) << text;
    EXPECT_THAT(outcome.err, HasSubstr(says)) << text;
  }
}

// An arm of six axes on a track: where the carriage stands is left to choose.
TEST(MapCommand, ChoosesWhereACarriageStands) {
  std::string robot = io::read_text(working_folder() / "data/robots/six_axis.yaml");
  const std::string first = "    - actuator: {name: q1,";
  robot.insert(robot.find(first),
               "    - actuator: {name: y, axis: Ty, stiffness: 5.0e7 N/m, range: [-400, 400]}\n");
  io::write_atomically(working_folder() / "on_a_track.yaml", robot);
  const std::string command =
      "map on_a_track.yaml --path data/paths/six_axis_seam.csv --index stiffness=1,0,0 ";
  const Outcome outcome = kinetostat(command + "--joint y -o track.csv --json track.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::CsvTable table = io::read_csv(working_folder() / "track.csv");
  // Not "y", which is a coordinate of the pose.
  EXPECT_EQ(table.columns().back(), "arm.y [mm]");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    EXPECT_GE(table.number(i, table.columns().size() - 1), -400 - 1e-9);
    EXPECT_LE(table.number(i, table.columns().size() - 1), 400 + 1e-9);
  }
  const io::Json choice = io::read_json(working_folder() / "track.json").at("choice");
  EXPECT_GE(choice.at("worst").get<double>(),
            (1 - 1e-9) * choice.at("worst_as_given").get<double>());
  // With a joint that the carriage leaves nothing, and one that it does.
  EXPECT_THAT(kinetostat(command + "--joint y --joint q1 --joint-range -400:400:3 "
                                   "--joint-range -90:90:3")
                  .err,
              HasSubstr("no freedom when 'arm.y' is held"));
}

TEST(MapCommand, SaysWhatAHeldJointNeeds) {
  const std::string seven =
      "map data/robots/seven_axis.yaml --index stiffness=0,0,1 "
      "--path data/paths/seven_axis_seam.csv ";
  const std::string six =
      "map data/robots/six_axis.yaml --index stiffness=1,0,0 --path data/paths/six_axis_seam.csv ";
  for (const auto& [options, says] :
       {std::pair(seven + "--joint arm.a12", "did you mean 'arm.a1'?"),
        std::pair(seven + "--joint elbow", "arm.a1, arm.a2, arm.a3"),
        std::pair(six + "--joint q1", "'arm.q1' has no limits"),
        std::pair(six + "--joint q1 --joint-range -90:90:5", "leave 'arm.q1' no freedom"),
        std::pair(six + "--joint q1 --joint-range -90:90:5", "No joint of this robot is redundant"),
        std::pair(seven + "--joint a4", "may move there while the platform stays: arm.a1, arm.a2"),
        std::pair(seven + "--joint a1 --joint-range 10:5:3", "least value first"),
        std::pair(seven + "--joint a1 --joint-range 10:50", "is no range"),
        std::pair(seven + "--joint a1 --joint-range -200:50:3", "-170 to 170 deg"),
        std::pair(seven + "--joint a1 --joint-range -9:9:3 --joint-range 0:1:3", "2 times for 1"),
        std::pair(seven + "--joint a1 --joint-change 0", "above zero"),
        std::pair(seven + "--joint a1 --joint arm.a1", "given twice"),
        std::pair(seven + "--joint a1 --joint a2 --joint a3", "more than 2"),
        std::pair(seven + "--joint a1 --joint a2", "no freedom when 'arm.a1' is held"),
        std::pair(seven + "--joint a1 --joint-range -9:9:3601 --turn z", "Try fewer values"),
        std::pair(std::string("map data/robots/seven_axis.yaml --index stiffness=0,0,1 "
                              "--grid x=500,z=400 --joint a1"),
                  "Give --path"),
        std::pair(std::string("map data/robots/orthoglide.yaml --index weakest-translation "
                              "--path data/paths/orthoglide_milling.csv --joint rho"),
                  "in several chains")}) {
    const Outcome outcome = kinetostat(options);
    EXPECT_EQ(outcome.code, 2) << options;
    EXPECT_THAT(outcome.err, HasSubstr(says)) << options;
  }
}

TEST(MapCommand, ItsTableAgreesWithTheStiffnessCommand) {
  ASSERT_EQ(kinetostat(orthoglide + "--grid x=0,y=0,z=0 --index stiffness=1,0,0 -o one.csv").code,
            0);
  const io::CsvTable table = io::read_csv(working_folder() / "one.csv");
  EXPECT_EQ(table.columns().back(), "stiffness=1 0 0 [N/mm]");
  // JAMRIS09 Table 1 in our numbers: 2.82e-4 mm/N.
  EXPECT_NEAR(1 / table.number(0, 7), 2.82e-4, 0.005e-4);
}

// A robot of three joints does not choose its orientation: no pose of a plain grid is reached, and
// every one of a grid of joints is. Values are those of the levers of its joints.
TEST(MapCommand, GoesOverTheJointsOfARobotOfOneChain) {
  io::write_atomically(
      working_folder() / "three.yaml",
      "kinetostat: 1\nname: three\nunits: {length: m, force: N, angle: deg}\nlinks:\n"
      "  upper: {rigid: [0.4, 0, 0]}\n  fore: {rigid: [0.3, 0, 0]}\n"
      "chain_types:\n  arm:\n    - actuator: {name: q1, axis: Rz, stiffness: 1e5 N m/rad}\n"
      "    - actuator: {name: q2, axis: Ry, stiffness: 8e4 N m/rad}\n    - link: upper\n"
      "    - actuator: {name: q3, axis: Ry, stiffness: 5e4 N m/rad}\n    - link: fore\n"
      "manipulator: {chain: arm}\n");
  const std::string map = "map three.yaml --index stiffness=0,0,1 ";
  const Outcome poses = kinetostat(map + "--grid x=0.3:0.6:3,y=0.1,z=-0.2");
  EXPECT_THAT(poses.out, HasSubstr("--grid q3=FROM:TO:POINTS"));
  ASSERT_EQ(kinetostat(map + "--grid q3=30:90:3,q2=-20:10:2 -o joints.csv").code, 0);
  const io::CsvTable table = io::read_csv(working_folder() / "joints.csv");
  ASSERT_EQ(table.rows(), 6u);
  EXPECT_EQ(table.columns()[6], "q2 [deg]");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double q2 = table.number(row, 6) * M_PI / 180, q3 = table.number(row, 7) * M_PI / 180;
    const double x = 0.4 * std::cos(q2) + 0.3 * std::cos(q2 + q3), x3 = 0.3 * std::cos(q2 + q3);
    EXPECT_NEAR(table.number(row, 0), x, 1e-11);
    EXPECT_NEAR(table.number(row, 9) * (x * x / 8e4 + x3 * x3 / 5e4), 1, 1e-9);  // levers
  }
  io::write_atomically(working_folder() / "path.csv", "q2,q3 [rad]\n10,0.5235987755982988\n");
  const Outcome path = kinetostat(map + "--path path.csv -o path_map.csv");
  ASSERT_EQ(path.code, 0) << path.err;
  EXPECT_NEAR(io::read_csv(working_folder() / "path_map.csv").number(0, 9), table.number(1, 9),
              1e-6 * table.number(1, 9));
  for (const auto& [options, says] :
       {std::pair(std::string("three.yaml --grid q2=0:1:2,x=1"), "not of both"),
        std::pair(std::string("three.yaml --grid q2=0:1:2,arm.q2=1"), "given twice"),
        std::pair(std::string("three.yaml --grid q7=0:1:2"), "name of a drive"),
        std::pair(std::string("three.yaml --path path.csv --turn z"), "leave nothing to choose"),
        std::pair(std::string("data/robots/orthoglide.yaml --grid x.rho=0:1:2"), "of one chain")}) {
    const Outcome outcome = kinetostat("map --index weakest-translation " + options);
    EXPECT_EQ(outcome.code, 2) << options;
    EXPECT_THAT(outcome.err, HasSubstr(says)) << options;
  }
}

TEST(MapCommand, CriticalForceIsWhatTheTraceEstimatesForItsBeams) {
  ASSERT_EQ(kinetostat(orthoglide + "--grid x=0,y=0,z=0 --index critical-force=-1,-1,-1 "
                                    "--up-to 20000 -o critical.csv")
                .code,
            0);
  const double ours = io::read_csv(working_folder() / "critical.csv").number(0, 7);
  ASSERT_EQ(kinetostat("trace data/robots/orthoglide.yaml --at 0,0,0 --wrench -9000,-9000,-9000 "
                       "--segments 1,2 --json critical.json")
                .code,
            0);
  const io::Json trace = io::read_json(working_folder() / "critical.json");
  EXPECT_NEAR(ours, trace["segments"]["estimate"].get<double>(), 1e-7 * ours);
}

TEST(MapCommand, PathMayHaveUnitsAndLoadsOfItsOwn) {
  io::write_atomically(working_folder() / "path.csv",
                       "x [m],y,fx [kN]\n0.02,5,0.1\n0.03,5,0.2\n9,0,0\n");
  const Outcome outcome =
      kinetostat(orthoglide + "--path path.csv --index deflection -o path_map.csv");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("3 poses, 2 reached, 1 unreachable"));
  const io::CsvTable table = io::read_csv(working_folder() / "path_map.csv");
  EXPECT_EQ(table.number(1, 0), 30);
  EXPECT_GT(table.number(1, 7), 1.9 * table.number(0, 7));
  EXPECT_EQ(table.cell(2, 6), "unreachable");
  EXPECT_TRUE(table.empty(2, 7));
}

struct MapMistake {
  const char* name;
  std::string arguments;
  int code;
  const char* message;
};
class MapMistakes : public testing::TestWithParam<MapMistake> {};

TEST_P(MapMistakes, AreNamed) {
  io::write_atomically(working_folder() / "typo.csv", "x,zz\n1,2\n");
  io::write_atomically(working_folder() / "no_pose.csv", "fx\n1\n");
  io::write_atomically(working_folder() / "loaded.csv", "x,fx\n1,2\n");
  io::write_atomically(working_folder() / "weights.csv", "x [kg]\n1\n");
  io::write_atomically(working_folder() / "old.part", "kinetostat map checkpoint 2\nabc\n");
  const Outcome outcome = kinetostat(orthoglide + GetParam().arguments);
  EXPECT_EQ(outcome.code, GetParam().code) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, MapMistakes,
    testing::Values(
        MapMistake{"no_poses", "--index rotation", 2, "neither a grid nor a path"},
        MapMistake{"no_index", "--grid x=0", 2, "--index is required"},
        MapMistake{"unknown_index", grid + "--index stifness=1,0,0", 2, "Did you mean 'stiffness'"},
        MapMistake{"no_direction", grid + "--index stiffness", 2, "needs a direction"},
        MapMistake{"zero_direction", grid + "--index stiffness=0,0,0", 2, "has no length"},
        MapMistake{"no_length", grid + "--index weakest", 2, "needs a length"},
        MapMistake{"negative_length", grid + "--index condition=-1", 2, "not above zero"},
        MapMistake{"no_load", grid + "--index deflection", 2, "no load and no weight"},
        MapMistake{"no_limit", grid + "--index critical-force=1,0,0", 2,
                   "--up-to: a critical force"},
        MapMistake{"wrench_beside_critical_force",
                   grid + "--index critical-force=1,0,0 --up-to 1e5 --wrench 1,0,0", 2,
                   "grows from nothing"},
        MapMistake{"unknown_axis", "--grid q=0:1:2 --index rotation", 2, "'q=0:1:2'"},
        MapMistake{"axis_twice", "--grid x=0,x=1 --index rotation", 2, "given twice"},
        MapMistake{"half_a_point", "--grid x=0:1:2.5 --index rotation", 2, "number of points"},
        MapMistake{"two_parts", "--grid x=0:1 --index rotation", 2, "from:to:points"},
        MapMistake{"too_many", "--grid x=0:1:9999,y=0:1:9999 --index rotation", 2, "poses, more"},
        MapMistake{"missing_path", "--path nowhere.csv --index weakest-rotation", 3, "nowhere.csv"},
        MapMistake{"column", "--path typo.csv --index weakest-rotation", 3, "typo.csv:1: zz"},
        MapMistake{"no_pose", "--path no_pose.csv --index weakest-rotation", 3, "no column states"},
        MapMistake{"column_unit", "--path weights.csv --index weakest-rotation", 3, "x [kg]"},
        MapMistake{"two_loads", "--path loaded.csv --wrench 1,0,0 --index rotation", 2,
                   "loads of its own"},
        MapMistake{"old_checkpoint", grid + "--checkpoint old.part", 3, "old.part:2"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace kinetostat::map_test
