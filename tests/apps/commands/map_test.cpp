// kinetostat map as its users meet it.
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
        std::pair(path + "--turn x --turn-range 10:5:3", "least angle first"),
        std::pair(path + "--turn x --turn-change 0", "above zero"),
        std::pair(path + "--place w=1", "--place")}) {
    const Outcome outcome = kinetostat(robot + options);
    EXPECT_EQ(outcome.code, 2) << options;
    EXPECT_THAT(outcome.err, HasSubstr(says)) << options;
  }
  EXPECT_THAT(kinetostat("map data/robots/six_axis.yaml --index first-frequency --grid x=1000").err,
              HasSubstr("needs masses"));
}

TEST(MapCommand, ItsTableAgreesWithTheStiffnessCommand) {
  ASSERT_EQ(kinetostat(orthoglide + "--grid x=0,y=0,z=0 --index stiffness=1,0,0 -o one.csv").code,
            0);
  const io::CsvTable table = io::read_csv(working_folder() / "one.csv");
  EXPECT_EQ(table.columns().back(), "stiffness=1 0 0 [N/mm]");
  // JAMRIS09 Table 1 in our numbers: 2.82e-4 mm/N.
  EXPECT_NEAR(1 / table.number(0, 7), 2.82e-4, 0.005e-4);
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
