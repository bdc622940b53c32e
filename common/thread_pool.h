// Threads that share out independent items of work, again and again.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kinetostat::common {

/// Keeps its threads between calls and lets them sleep meanwhile: the loops of a solver are too
/// short to start threads for each, and a machine may have other work.
class ThreadPool {
 public:
  /// The caller is one of the threads. Where the system has no more of them, fewer do the work.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(others_.size()) + 1; }

  /// Calls work(i) for every i below `count`, each once, by whoever is free; returns when all are
  /// done. The calls must not depend on each other. When some throw, the exception of the smallest
  /// such i is passed on, and not all calls that follow it are made.
  void for_each(int count, const std::function<void(int)>& work);

  /// Calls work(i, begin, end) for the i-th of the pieces of at most `size` numbers that make up
  /// 0 to count - 1. The pieces do not depend on the number of threads.
  void for_each_piece(std::size_t count, std::size_t size,
                      const std::function<void(int, std::size_t, std::size_t)>& work);
  static int pieces(std::size_t count, std::size_t size) {
    return static_cast<int>((count + size - 1) / size);
  }

 private:
  void serve();
  void take_items();

  std::vector<std::thread> others_;
  const std::function<void(int)>* work_ = nullptr;
  std::atomic<int> next_ = 0;
  std::atomic<int> end_ = 0;        // of the items; the smallest that has thrown, if one has
  std::atomic<int> busy_ = 0;       // other threads that have not finished this call
  std::atomic<unsigned> call_ = 0;  // its number
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;  // of the error
  std::exception_ptr error_;
};

}  // namespace kinetostat::common
