// A robot for simulators, as its user asks for it; what is in the file: vjm/io/mjcf_export_test.
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
  EXPECT_THAT(outcome.out, testing::StartsWith("six-axis arm for MuJoCo, written to arm.xml."));
  EXPECT_THAT(outcome.out, HasSubstr("not in it: damping and friction"));
  const std::string text = io::read_text(working_folder() / "arm.xml");
  EXPECT_THAT(text, testing::StartsWith("<mujoco model=\"six-axis arm\">"));
  const io::Json result = io::read_json(working_folder() / "arm.json");
  EXPECT_EQ(result["mjcf"], text);
  EXPECT_EQ(result["lost"].size(), 1u);
  // Without a file it is printed.
  EXPECT_EQ(kinetostat("export data/robots/six_axis.yaml --joints q2=-20,q3=40").out, text);
}

TEST(ExportCommand, RefusesRobotsOfSeveralChains) {
  const test::Outcome outcome = kinetostat("export data/robots/delta.yaml");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("delta.yaml: only a robot of one chain"));
}

}  // namespace
}  // namespace kinetostat::export_test
