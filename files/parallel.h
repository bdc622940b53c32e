// A loop over independent items on several threads, with the same result for any number of them.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "kinetostat/files/progress.h"

namespace kinetostat::files {

/// Calls work(i) for every i below `count`. The calls must not depend on each other. When some
/// throw, the exception of the smallest such i is passed on, and not all that follow it are tried;
/// cancellation ends the loop early with Cancelled. Where the system has no more threads, fewer do
/// the work.
template <class Work>
void parallel_for(std::size_t count, int threads, std::string_view phase, Progress& progress,
                  const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> failed = count;  // the smallest that has thrown
  std::mutex mutex;
  std::exception_ptr error;
  const auto run = [&](bool shows_progress) {
    for (std::size_t i = next++; i < failed; i = next++) {
      try {
        if (shows_progress && i % 64 == 0)
          progress.report(phase, static_cast<double>(i) / static_cast<double>(count));
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i < failed) {
          failed = i;
          error = std::current_exception();
        }
      }
    }
  };
  std::vector<std::thread> others;
  const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(threads, 1)), count);
  try {
    for (std::size_t t = 1; t < wanted; ++t) others.emplace_back(run, false);
  } catch (const std::system_error&) {  // those that there are suffice
  }
  run(true);
  for (std::thread& thread : others) thread.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace kinetostat::files
