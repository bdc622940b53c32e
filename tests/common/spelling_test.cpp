#include "kinetostat/common/spelling.h"

#include <gtest/gtest.h>

namespace kinetostat::common::spelling_test {
namespace {

TEST(Spelling, FindsTypingErrors) {
  const std::vector<std::string> keys{"length", "section", "material", "segments"};
  EXPECT_EQ(nearest_spelling("lenght", keys), "length");       // swapped
  EXPECT_EQ(nearest_spelling("segment", keys), "segments");    // left out
  EXPECT_EQ(nearest_spelling("materiall", keys), "material");  // doubled
  EXPECT_EQ(nearest_spelling("SECTION", keys), "section");
}

// Otherwise a binary file that is taken for a table is compared letter by letter for minutes.
TEST(Spelling, DoesNotReadEndlessWords) {
  const std::vector<std::string> keys(1000, "a key like those of a file");
  EXPECT_EQ(nearest_spelling(std::string(2'000'000, 'a'), keys), "");
  const std::string text(500'000, 'a');
  EXPECT_EQ(nearest_spelling(text + "b", {text, text + "c"}), "");
}

TEST(Spelling, DoesNotGuessWildly) {
  EXPECT_EQ(nearest_spelling("colour", {"length", "section"}), "");
  EXPECT_EQ(nearest_spelling("x", {"m", "s"}), "");  // no letter in common
  EXPECT_EQ(nearest_spelling("word", {}), "");
  EXPECT_EQ(nearest_spelling("", {"m"}), "");
}

}  // namespace
}  // namespace kinetostat::common::spelling_test
