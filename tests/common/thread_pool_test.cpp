#include "kinetostat/common/thread_pool.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::common::thread_pool_test {
namespace {

TEST(ThreadPool, PassesOnAnExceptionAndGoesOn) {
  ThreadPool pool(3);
  for (int call = 0; call < 20; ++call) {
    EXPECT_THROW(pool.for_each(100, [](int) { throw std::bad_alloc(); }), std::bad_alloc);
    std::atomic<int> done = 0;
    pool.for_each(100, [&done](int) { ++done; });
    EXPECT_EQ(done, 100);
  }
}

TEST(ThreadPool, DoesEveryItemOnceInEveryCall) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const int count : {0, 1, 3, 100})
      for (int call = 0; call < 200; ++call) {
        std::vector<int> visits(static_cast<std::size_t>(count), 0);
        pool.for_each(count, [&](int i) { ++visits[static_cast<std::size_t>(i)]; });
        ASSERT_THAT(visits, testing::Each(1));
      }
  }
}

}  // namespace
}  // namespace kinetostat::common::thread_pool_test
