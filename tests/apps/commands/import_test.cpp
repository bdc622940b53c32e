// kinetostat import as its users meet it.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::import_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

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
