#include "kinetostat/common/parallel.h"

#include <fstream>
#include <numeric>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

#include <gtest/gtest.h>

namespace kinetostat::common::parallel_test {
namespace {

constexpr std::size_t count = 1000;

// Every item writes to a place of its own.
std::vector<std::size_t> squares(int threads) {
  std::vector<std::size_t> result(count);
  Progress silent;
  parallel_for(count, threads, "", silent, [&](std::size_t i) { result[i] = i * i; });
  return result;
}

TEST(Parallel, DoesEveryItemOnceWhateverTheNumberOfThreads) {
  std::vector<std::size_t> expected(count);
  for (std::size_t i = 0; i < count; ++i) expected[i] = i * i;
  for (const int threads : {0, 1, 2, 7, 2000}) EXPECT_EQ(squares(threads), expected) << threads;
}

// The same complaint, however the threads take turns.
TEST(Parallel, PassesOnTheExceptionOfTheSmallestItemThatThrows) {
  Progress silent;
  for (int turn = 0; turn < 200; ++turn) {
    std::string what;
    try {
      parallel_for(count, 8, "", silent, [](std::size_t i) {
        if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
      });
    } catch (const std::runtime_error& error) {
      what = error.what();
    }
    ASSERT_EQ(what, "7") << turn;
  }
}

// Memory for a few stacks more than there are.
void leave_room_for_few_threads() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t bytes = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + (30u << 20);
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_AS, &limit);
}

TEST(Parallel, FewerThreadsDoWhereTheSystemHasNoMore) {
  EXPECT_EXIT(
      {
        leave_room_for_few_threads();
        std::vector<std::size_t> all = squares(200);
        std::_Exit(all.back() == (count - 1) * (count - 1) ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace kinetostat::common::parallel_test
