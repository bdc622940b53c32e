// kinetostat beam as its users meet it.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"

#include "apps/run_program.h"

namespace kinetostat::beam_command_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

// JAMRIS09 section 4.3: about 50 % for a single beam, 30 % for four, against FEA.
TEST(BeamCommand, OrthoglideFootNeedsMoreThanOneBeamAsPublished) {
  const Outcome outcome =
      kinetostat("beam meshes/foot.yaml --fea data/links/foot.link.json --json beam.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const io::Json json = io::read_json(working_folder() / "beam.json");
  const auto error = [&json](int model) {
    return json["comparison"][model]["worst_error"].get<double>();
  };
  EXPECT_EQ(json["models"][0]["name"], "1 beam");
  EXPECT_NEAR(error(0), 0.5, 0.15);
  EXPECT_LE(error(1), 0.3);
  EXPECT_LT(error(2), error(1));
  EXPECT_THAT(outcome.out, HasSubstr("differs by up to"));
  EXPECT_EQ(json["sections"].size(), 24u);
}

TEST(BeamCommand, SlenderBarNeedsOneBeamOnly) {
  const Outcome outcome = kinetostat("beam meshes/bar.yaml --fea data/links/bar.link.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("1 beam is enough for 10 %"));
}

TEST(BeamCommand, SameInputGivesTheSameBytes) {
  const std::string call = "beam meshes/bar.yaml --fea data/links/bar.link.json --json - ";
  EXPECT_EQ(kinetostat(call + "--threads 1").out, kinetostat(call + "--threads 2").out);
}

TEST(BeamCommand, WrongResultsAndNamesAreNoticed) {
  EXPECT_THAT(kinetostat("beam meshes/bar.yaml --fea data/links/foot.link.json").out,
              HasSubstr("was identified from another mesh"));
  const Outcome unknown = kinetostat("beam meshes/bar.yaml --interface tip");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("There is loaded"));
  EXPECT_EQ(kinetostat("beam meshes/bar.yaml --beams 1").code, 2);
  EXPECT_EQ(kinetostat("beam meshes/bar.yaml --fea nowhere.json").code, 3);
  EXPECT_EQ(kinetostat("beam nowhere.yaml").code, 3);
}

}  // namespace
}  // namespace kinetostat::beam_command_test
