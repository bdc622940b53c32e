#include "kinetostat/common/build_id.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "kinetostat/common/child_process.h"

namespace kinetostat::common::build_id_test {

TEST(BuildId, IsWhatReadelfFindsInTheProgram) {
  Progress silent;
  const std::string program = std::filesystem::canonical("/proc/self/exe");
  const ChildResult notes = run_child({.program = find_program("readelf"),
                                       .arguments = {"-n", program},
                                       .input = {},
                                       .time_limit = 60},
                                      "test", silent);
  ASSERT_EQ(notes.code, 0) << notes.words;
  ASSERT_EQ(build_id().size(), 40U);  // SHA-1
  EXPECT_NE(notes.words.find("Build ID: " + build_id()), std::string::npos) << notes.words;
}

}  // namespace kinetostat::common::build_id_test
