#include "kinetostat/common/faults.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::common::faults_test {
namespace {

using testing::HasSubstr;

std::string message_of(const Faults& faults) {
  try {
    faults.throw_if_any();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(Faults, NoneIsNoError) { EXPECT_EQ(message_of({}), "nothing thrown"); }

TEST(Faults, OneIsAnOrdinaryError) {
  const InputError::Details mistake{.file = "t.csv",
                                    .line = 3,
                                    .column = 5,
                                    .key = "fx",
                                    .what = "'a' is no number",
                                    .cure = "Go"};
  Faults faults;
  faults.add(mistake);
  EXPECT_EQ(message_of(faults), InputError(mistake).what());
}

TEST(Faults, SeveralAreSortedByPlaceAndGroupedByKind) {
  Faults faults;
  faults.add({.file = "t.csv", .line = 9, .column = 1, .what = "last", .cure = "Mend it"});
  for (int line : {7, 4, 5})
    faults.add({.file = "t.csv",
                .line = line,
                .column = 2,
                .key = "fx",
                .what = "'" + std::to_string(line) + "a' is no number",
                .cure = "Write one"});
  faults.add({.file = "c.yaml", .line = 1, .key = "units", .what = "unknown"});
  const std::string message = message_of(faults);
  EXPECT_THAT(message, HasSubstr("3 things to repair"));
  EXPECT_THAT(message, HasSubstr("fx: '4a' is no number (and on lines 5, 7)"));
  EXPECT_LT(message.find("unknown"), message.find("'4a'"));
  EXPECT_LT(message.find("'4a'"), message.find("last"));
}

// A table of mistakes from one to another place keeps all of them.
TEST(Faults, TakeOverThoseOfAnError) {
  Faults first, all;
  first.add({.file = "t.csv", .line = 1, .what = "one"});
  first.add({.file = "t.csv", .line = 2, .what = "two"});
  try {
    first.throw_if_any();
  } catch (const InputError& error) {
    all.add(error);
  }
  EXPECT_EQ(all.mistakes().size(), 2u);
}

// As a terminal of 100 columns shows it, with the lines that a program has around it.
std::size_t lines_on_screen(const std::string& text) {
  std::size_t lines = 0;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines += 1 + line.size() / 101;
  return lines;
}

TEST(Faults, ALongListIsCutToAScreenAndThereAsAWhole) {
  for (const std::size_t length : {10, 90, 1000}) {
    Faults faults;
    for (int i = 1; i <= 100; ++i)
      faults.add({.file = "t.csv",
                  .line = i,
                  .what = "mistake " + std::to_string(i) + std::string(length, 'x'),
                  .cure = i % 2 == 0 ? "Write it otherwise" : ""});
    try {
      faults.throw_if_any();
      FAIL() << "nothing thrown";
    } catch (const InputErrors& errors) {
      const std::string screen = errors.what(), all = errors.all();
      EXPECT_TRUE(errors.is_cut());
      EXPECT_THAT(screen, HasSubstr("100 things to repair"));
      EXPECT_LE(lines_on_screen(screen), 23u) << screen;
      EXPECT_GE(lines_on_screen(screen), 16u) << screen;
      const std::size_t end = screen.rfind("\n  and "), rows = std::stoul(screen.substr(end + 7));
      EXPECT_TRUE(all.starts_with(screen.substr(0, end)));
      EXPECT_EQ(all.find("mistake " + std::to_string(100 - rows)) < end, true);
      for (int i = 1; i <= 100; ++i)
        EXPECT_THAT(all, HasSubstr("mistake " + std::to_string(i) + "xxx"));
    }
  }
}

TEST(Faults, AShortListIsWhole) {
  Faults faults;
  for (int i = 1; i <= 20; ++i)
    faults.add({.file = "t.csv", .line = i, .what = "mistake " + std::to_string(i)});
  try {
    faults.throw_if_any();
    FAIL() << "nothing thrown";
  } catch (const InputErrors& errors) {
    EXPECT_FALSE(errors.is_cut());
    EXPECT_EQ(errors.all(), errors.what());
  }
}

}  // namespace
}  // namespace kinetostat::common::faults_test
