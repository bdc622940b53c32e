#include "kinetostat/common/error.h"

#include <gtest/gtest.h>

#include "kinetostat/common/out_of_memory.h"

namespace kinetostat::common::error_test {
namespace {

TEST(InputError, ReadsLikeACompilerMessage) {
  const InputError error({.file = "robot.yaml",
                          .line = 12,
                          .column = 3,
                          .key = "links.leg.length",
                          .what = "'-3 mm' is not positive",
                          .cure = "Give a length above zero"});
  EXPECT_STREQ(
      error.what(),
      "robot.yaml:12:3: links.leg.length: '-3 mm' is not positive. Give a length above zero.");
}

TEST(InputError, LeavesOutWhatIsNotKnown) {
  EXPECT_STREQ(InputError("a.stl", "is open").what(), "a.stl: is open.");
  EXPECT_STREQ(InputError({.what = "Nothing to do"}).what(), "Nothing to do.");
  EXPECT_STREQ(InputError("a", "b", "Did you mean 'c'?").what(), "a: b. Did you mean 'c'?");
}

TEST(OutOfMemory, ReadsLikeOne) {
  const OutOfMemory error("9 nodes need more memory than there is", "Use fewer", "a.yaml");
  EXPECT_STREQ(error.what(), "a.yaml: 9 nodes need more memory than there is. Use fewer.");
  EXPECT_EQ(error.reason(), "9 nodes need more memory than there is");
  EXPECT_STREQ(OutOfMemory("a", "b").what(), "a. b.");
}

TEST(InputError, QuotesNeitherBytesNorWholeFiles) {
  const std::string bytes = "\x1b[2J \xff\xfe \x80 caf\xc3\xa9 5 \xc2\xb5m \xe2\x82";
  EXPECT_STREQ(InputError("a", bytes).what(), "a: ?[2J ?? ? caf\xc3\xa9 5 \xc2\xb5m ??");
  const std::string whole = "begin" + std::string(100000, 'x') + "end";
  const std::string said = InputError("a", whole).what();
  EXPECT_LT(said.size(), 1100u);
  EXPECT_TRUE(said.starts_with("a: begin"));
  EXPECT_TRUE(said.ends_with("end."));
}

}  // namespace
}  // namespace kinetostat::common::error_test
