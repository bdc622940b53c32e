#include "kinetostat/fea/team.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::fea {
namespace {

TEST(Team, PassesOnAnExceptionAndGoesOn) {
  Team team(3);
  for (int call = 0; call < 20; ++call) {
    EXPECT_THROW(team.for_each(100, [](int) { throw std::bad_alloc(); }), std::bad_alloc);
    std::atomic<int> done = 0;
    team.for_each(100, [&done](int) { ++done; });
    EXPECT_EQ(done, 100);
  }
}

TEST(Team, DoesEveryItemOnceInEveryCall) {
  for (const int threads : {1, 2, 5}) {
    Team team(threads);
    EXPECT_EQ(team.threads(), threads);
    for (const int count : {0, 1, 3, 100})
      for (int call = 0; call < 200; ++call) {
        std::vector<int> visits(static_cast<std::size_t>(count), 0);
        team.for_each(count, [&](int i) { ++visits[static_cast<std::size_t>(i)]; });
        ASSERT_THAT(visits, testing::Each(1));
      }
  }
}

}  // namespace
}  // namespace kinetostat::fea
