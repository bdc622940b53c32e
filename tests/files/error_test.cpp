#include "kinetostat/files/error.h"

#include <gtest/gtest.h>

namespace kinetostat::files {
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

}  // namespace
}  // namespace kinetostat::files
