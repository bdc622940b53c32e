// A robot for simulators, as its user asks for it; what is in the file:
// vjm/exchange/tree_export_test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::export_test {
namespace {

using test::kinetostat;
using test::working_folder;
using testing::HasSubstr;

TEST(ExportCommand, WritesTheFileAndSaysWhatIsNotInIt) {
  const test::Outcome outcome = kinetostat(
      "export data/robots/six_axis.yaml --joints q2=-20,q3=40 -o arm.xml --json arm.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              testing::StartsWith("six-axis arm for MuJoCo (MJCF), written to arm.xml."));
  EXPECT_THAT(outcome.out, HasSubstr("not in it: damping and friction"));
  const std::string text = io::read_text(working_folder() / "arm.xml");
  EXPECT_THAT(text, testing::StartsWith("<mujoco model=\"six-axis arm\">"));
  const io::Json result = io::read_json(working_folder() / "arm.json");
  EXPECT_EQ(result["text"], text);
  EXPECT_EQ(result["format"], "mjcf");
  EXPECT_EQ(result["lost"].size(), 2u);  // of a robot whose links have no mass
  // Without a file it is printed.
  EXPECT_EQ(kinetostat("export data/robots/six_axis.yaml --joints q2=-20,q3=40").out, text);
}

TEST(ExportCommand, TakesTheFormatFromTheFileOrTheOption) {
  for (const auto& [file, start] : {std::pair{"arm.urdf", "<?xml version=\"1.0\"?>\n<robot"},
                                    {"arm.sdf", "<?xml version=\"1.0\"?>\n<sdf"},
                                    {"arm.mo", "model six_axis_arm"},
                                    {"arm.m", "% Small motions"}}) {
    const std::string name = file;
    const test::Outcome outcome = kinetostat("export data/robots/six_axis.yaml -o " + name);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("not in it: "));
    EXPECT_THAT(io::read_text(working_folder() / name), testing::StartsWith(start));
  }
  EXPECT_THAT(kinetostat("export data/robots/six_axis_urdf.yaml --format sdf --damping 0.02").out,
              HasSubstr("<damping>"));
  const test::Outcome unknown = kinetostat("export data/robots/six_axis.yaml -o arm.txt");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr(".sdf"));
}

TEST(ExportCommand, WarnsOfJointsOutsideOfTheirRanges) {
  const std::string robot = "export data/robots/gantry.yaml --format matlab --joints ";
  EXPECT_THAT(kinetostat(robot + "x=9999").err, HasSubstr("outside of its range"));
}

TEST(ExportCommand, RefusesRobotsOfSeveralChainsButForMatlab) {
  const test::Outcome outcome = kinetostat("export data/robots/delta.yaml");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("delta.yaml: only a robot of one chain"));
  EXPECT_EQ(kinetostat("export data/robots/delta.yaml -o delta.m").code, 0);
}

}  // namespace
}  // namespace kinetostat::export_test
