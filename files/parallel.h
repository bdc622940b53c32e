// A loop over independent items on several threads, with the same result for any number of them.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "kinetostat/files/progress.h"

namespace kinetostat::files {

/// Calls work(i) for every i below `count`. The calls must not depend on each other. When some
/// throw, the exception of the smallest such i that was tried is passed on; cancellation ends the
/// loop early with Cancelled.
template <class Work>
void parallel_for(std::size_t count, int threads, std::string_view phase, Progress& progress,
                  const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> stop = false;
  std::mutex mutex;
  std::exception_ptr error;
  std::size_t failed = std::numeric_limits<std::size_t>::max();
  const auto run = [&](bool shows_progress) {
    for (std::size_t i = next++; i < count && !stop; i = next++) {
      try {
        if (shows_progress && i % 64 == 0)
          progress.report(phase, static_cast<double>(i) / static_cast<double>(count));
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        stop = true;
        if (i < failed) {
          failed = i;
          error = std::current_exception();
        }
      }
    }
  };
  std::vector<std::thread> others;
  const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(threads, 1)), count);
  for (std::size_t t = 1; t < wanted; ++t) others.emplace_back(run, false);
  run(true);
  for (std::thread& thread : others) thread.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace kinetostat::files
