// Diagnoses that somebody has edited, or that are something else, given to the commands that read
// them.
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::broken_diagnosis_test {
namespace {

using io::Json;
using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

const std::string campaign = "data/measurements/nist_load_cell/campaign.yaml";

// Of the load cell whose stiffness grows with the load.
class BrokenDiagnosis : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_EQ(kinetostat("diagnose data/robots/bench.yaml " + campaign +
                         " -q -o sound.json --draws 99 --effects load_hardening")
                  .code,
              0);
    std::filesystem::copy_file(working_folder() / "data/robots/bench.yaml",
                               working_folder() / "bench.yaml",
                               std::filesystem::copy_options::overwrite_existing);
  }
  // The diagnosis with another value in one place.
  static void write(const std::string& place, const Json& value) {
    Json json = io::read_json(working_folder() / "sound.json");
    json.at(Json::json_pointer(place)) = value;
    io::write_json(working_folder() / "broken.json", json);
  }
  static Outcome adopt(const std::string& more = "") {
    return kinetostat("adopt bench.yaml broken.json -o adopted.yaml " + more);
  }
};

TEST_F(BrokenDiagnosis, IsRefusedByAdopt) {
  for (const char* place :
       {"/inputs", "/inputs/robot", "/inputs/robot/sha256", "/found", "/found/0", "/found/0/effect",
        "/found/0/parameters", "/found/0/parameters/0", "/found/0/values", "/found/0/deviations",
        "/waterfall", "/waterfall/0", "/verdict"}) {
    write(place, 7);
    const Outcome outcome = adopt();
    EXPECT_EQ(outcome.code, 3) << place << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("this is not a diagnosis")) << place;
    EXPECT_FALSE(std::filesystem::exists(working_folder() / "adopted.yaml"));
  }
}

TEST_F(BrokenDiagnosis, IsRefusedByPlan) {
  for (const char* place : {"/inputs", "/inputs/robot/sha256", "/verdict", "/found", "/steps"}) {
    write(place, 7);
    const Outcome outcome = kinetostat("plan " + campaign + " --diagnosis broken.json");
    EXPECT_EQ(outcome.code, 3) << place << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("broken.json")) << place;
  }
}

// A verdict that names something, with nothing in the list of what was found.
TEST_F(BrokenDiagnosis, AmbiguousWithoutAnythingFoundIsNoCrash) {
  write("/verdict", "ambiguous");
  Json json = io::read_json(working_folder() / "broken.json");
  json["found"] = Json::array();
  json["ambiguous"] = {"load_hardening at cell.spring"};
  io::write_json(working_folder() / "broken.json", json);
  const int code = kinetostat("plan " + campaign + " --diagnosis broken.json --minutes 10").code;
  EXPECT_THAT(code, testing::AnyOf(0, 5));
}

TEST_F(BrokenDiagnosis, WhatDoesNotReadBackIsNotWritten) {
  write("/found/0/at", "nowhere");
  const Outcome outcome = adopt("--force");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("adopted.yaml"));
  EXPECT_THAT(outcome.err, HasSubstr("as it would be written, it does not read back"));
  EXPECT_THAT(outcome.err, testing::Not(HasSubstr("trial")));
  for (const char* file : {"adopted.yaml", "adopted.yaml.trial.yaml"})
    EXPECT_FALSE(std::filesystem::exists(working_folder() / file)) << file;
}

TEST_F(BrokenDiagnosis, AdoptingWritesThroughALink) {
  const std::filesystem::path link = working_folder() / "link.yaml";
  std::filesystem::create_symlink("bench.yaml", link);
  EXPECT_EQ(kinetostat("adopt link.yaml sound.json --force -q").code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_THAT(io::read_text(working_folder() / "bench.yaml"), HasSubstr("effect: load_hardening"));
  EXPECT_EQ(kinetostat("revert link.yaml -q").code, 0);
  EXPECT_EQ(io::read_text(link), io::read_text(working_folder() / "data/robots/bench.yaml"));
}

}  // namespace
}  // namespace kinetostat::broken_diagnosis_test
