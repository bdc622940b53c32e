// kinetostat import as its users meet it.
#include <string>

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
