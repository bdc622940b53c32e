#include "kinetostat/fea/team.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace kinetostat::fea {

Team::Team(int threads) {
  try {
    for (int t = 1; t < threads; ++t) others_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {  // those that there are suffice
  }
}

Team::~Team() {
  stop_ = true;
  ++call_;
  call_.notify_all();
  for (std::thread& thread : others_) thread.join();
}

void Team::for_each(int count, const std::function<void(int)>& work) {
  work_ = &work;
  count_ = count;
  next_ = 0;
  busy_ = static_cast<int>(others_.size());
  ++call_;
  call_.notify_all();
  take_items();
  for (int busy = busy_; busy > 0; busy = busy_) busy_.wait(busy);
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void Team::for_each_piece(std::size_t count, std::size_t size,
                          const std::function<void(int, std::size_t, std::size_t)>& work) {
  for_each(pieces(count, size), [&](int i) {
    const std::size_t begin = static_cast<std::size_t>(i) * size;
    work(i, begin, std::min(begin + size, count));
  });
}

void Team::serve() {
  for (unsigned seen = 0;;) {
    call_.wait(seen);
    seen = call_;
    if (stop_) return;
    take_items();
    if (--busy_ == 0) busy_.notify_all();
  }
}

void Team::take_items() {
  try {
    for (int i = next_++; i < count_; i = next_++) (*work_)(i);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::current_exception();
    next_ = count_;
  }
}

}  // namespace kinetostat::fea
