#include "kinetostat/common/thread_pool.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace kinetostat::common {

ThreadPool::ThreadPool(int threads) {
  try {
    for (int t = 1; t < threads; ++t) others_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {  // those that there are suffice
  }
}

ThreadPool::~ThreadPool() {
  stop_ = true;
  ++call_;
  call_.notify_all();
  for (std::thread& thread : others_) thread.join();
}

void ThreadPool::for_each(int count, const std::function<void(int)>& work) {
  work_ = &work;
  end_ = count;
  next_ = 0;
  busy_ = static_cast<int>(others_.size());
  ++call_;
  call_.notify_all();
  take_items();
  for (int busy = busy_; busy > 0; busy = busy_) busy_.wait(busy);
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void ThreadPool::for_each_piece(std::size_t count, std::size_t size,
                                const std::function<void(int, std::size_t, std::size_t)>& work) {
  for_each(pieces(count, size), [&](int i) {
    const std::size_t begin = static_cast<std::size_t>(i) * size;
    work(i, begin, std::min(begin + size, count));
  });
}

void ThreadPool::serve() {
  for (unsigned seen = 0;;) {
    call_.wait(seen);
    seen = call_;
    if (stop_) return;
    take_items();
    if (--busy_ == 0) busy_.notify_all();
  }
}

void ThreadPool::take_items() {
  for (int i = next_++; i < end_; i = next_++) {
    try {
      (*work_)(i);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (i < end_) {
        end_ = i;
        error_ = std::current_exception();
      }
    }
  }
}

}  // namespace kinetostat::common
