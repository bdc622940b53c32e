#include "kinetostat/apps/cli/progress_bar.h"

#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::apps::progress_bar_test {
namespace {

std::string shown(ProgressBar::Style style) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* stream = open_memstream(&text, &size);
  {
    ProgressBar bar(stream, style);
    bar.report("meshing", 0);
    for (int i = 0; i < 1000; ++i) bar.report("solving", 1e-3 * i);
  }
  std::fclose(stream);
  const std::string result(text, size);
  std::free(text);
  return result;
}

TEST(ProgressBar, LinesAreFewAndNameThePhases) {
  EXPECT_EQ(shown(ProgressBar::Style::lines), "meshing\nsolving\n");
}

TEST(ProgressBar, ALogNamesAPhaseThatComesBackOnce) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* stream = open_memstream(&text, &size);
  {
    ProgressBar bar(stream, ProgressBar::Style::lines);
    for (int i = 0; i < 5; ++i) {
      bar.report("loaded equilibria", 0);
      bar.report("states without load", 0);
    }
  }
  std::fclose(stream);
  EXPECT_EQ(std::string(text, size), "loaded equilibria\nstates without load\n");
  std::free(text);
}

TEST(ProgressBar, BarIsWipedAtTheEnd) {
  const std::string text = shown(ProgressBar::Style::bar);
  EXPECT_THAT(text, testing::HasSubstr("meshing"));
  EXPECT_THAT(text, testing::EndsWith("\r\x1b[K"));
}

TEST(ProgressBar, NoneShowsNothing) { EXPECT_EQ(shown(ProgressBar::Style::none), ""); }

// 100 s for the whole, of which the first 60 % were there before.
TEST(Pace, WhatWasFoundAtTheStartDoesNotCount) {
  Pace pace;
  for (int i = 0; i <= 60; ++i) pace.add(1e-3 * i, 0.01 * i);
  EXPECT_FALSE(pace.left());
  for (int i = 1; i <= 10; ++i) pace.add(0.06 + i, 0.6 + 0.01 * i);
  ASSERT_TRUE(pace.left());
  EXPECT_NEAR(*pace.left(), 30, 0.5);
}

// Steps that take long tell nothing while they last.
TEST(Pace, IsThatOfTheLaterHalf) {
  Pace pace;
  pace.add(0, 0);
  pace.add(10, 0.5);
  EXPECT_NEAR(*pace.left(), 10, 1e-9);
  pace.add(50, 0.75);  // the last step: a quarter in 40 s
  EXPECT_NEAR(*pace.left(), 40, 1e-9);
  pace.add(200, 0.75);
  EXPECT_FALSE(pace.left());
  pace.add(210, 1);
  EXPECT_FALSE(pace.left());
}

TEST(ProgressBar, ClockReadsLikeAClock) {
  EXPECT_EQ(clock_text(0.4), "0:00");
  EXPECT_EQ(clock_text(65), "1:05");
  EXPECT_EQ(clock_text(7325), "2:02:05");
}

}  // namespace
}  // namespace kinetostat::apps::progress_bar_test
