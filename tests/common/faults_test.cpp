#include "kinetostat/common/faults.h"

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

TEST(Faults, ALongListIsCut) {
  Faults faults;
  for (int i = 1; i <= 100; ++i)
    faults.add({.file = "t.csv",
                .line = i,
                .what = "mistake " + std::string(1000, 'x') + std::to_string(i)});
  const std::string message = message_of(faults);
  EXPECT_THAT(message, HasSubstr("100 things to repair"));
  EXPECT_THAT(message, HasSubstr("and 85 more"));
  EXPECT_LT(message.size(), 10'000u);
}

}  // namespace
}  // namespace kinetostat::common::faults_test
