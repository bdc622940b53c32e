#include "kinetostat/apps/progress_bar.h"

#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::apps {
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

TEST(ProgressBar, BarIsWipedAtTheEnd) {
  const std::string text = shown(ProgressBar::Style::bar);
  EXPECT_THAT(text, testing::HasSubstr("meshing"));
  EXPECT_THAT(text, testing::EndsWith("\r\x1b[K"));
}

TEST(ProgressBar, NoneShowsNothing) { EXPECT_EQ(shown(ProgressBar::Style::none), ""); }

TEST(ProgressBar, ClockReadsLikeAClock) {
  EXPECT_EQ(clock_text(0.4), "0:00");
  EXPECT_EQ(clock_text(65), "1:05");
  EXPECT_EQ(clock_text(7325), "2:02:05");
}

}  // namespace
}  // namespace kinetostat::apps
