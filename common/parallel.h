// A loop over independent items on several threads, with the same result for any number of them.
#pragma once

#include <algorithm>
#include <string_view>
#include <thread>

#include "kinetostat/common/progress.h"
#include "kinetostat/common/thread_pool.h"

namespace kinetostat::common {

/// Calls work(i) for every i below `count`. The calls must not depend on each other. When some
/// throw, the exception of the smallest such i is passed on, and not all that follow it are tried;
/// cancellation ends the loop early with Cancelled. Where the system has no more threads, fewer do
/// the work.
template <class Work>
void parallel_for(std::size_t count, int threads, std::string_view phase, Progress& progress,
                  const Work& work) {
  const std::thread::id caller = std::this_thread::get_id();
  const auto items = static_cast<int>(count);
  ThreadPool(std::min(threads, items)).for_each(items, [&](int i) {
    if (i % 64 == 0 && std::this_thread::get_id() == caller)
      progress.report(phase, static_cast<double>(i) / static_cast<double>(count));
    work(static_cast<std::size_t>(i));
  });
}

}  // namespace kinetostat::common
