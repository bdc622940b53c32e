#include "kinetostat/python/long_call.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace kinetostat::python {
namespace {

namespace py = pybind11;

constexpr std::chrono::milliseconds between_looks(50);

// What was reported last, for the thread that waits.
class WatchedProgress : public common::Progress {
 public:
  using State = std::pair<std::string, double>;

  bool cancelled() const override { return stopped_; }
  void stop() { stopped_ = true; }
  /// None where nothing new was reported.
  std::optional<State> news() {
    const std::lock_guard lock(mutex_);
    return std::exchange(state_, std::nullopt);
  }

 private:
  void show(std::string_view phase, double fraction) override {
    const std::lock_guard lock(mutex_);
    state_ = State(phase, fraction);
  }

  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::optional<State> state_;
};

class Worker {
 public:
  Worker(const std::function<void(common::Progress&)>& work, WatchedProgress& progress)
      : thread_([this, &work, &progress] {
          try {
            work(progress);
          } catch (...) {
            failure_ = std::current_exception();
          }
          const std::lock_guard lock(mutex_);
          done_ = true;
          ended_.notify_one();
        }) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    if (thread_.joinable()) thread_.join();
  }

  bool ends_within(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, time, [this] { return done_; });
  }
  void finish() {
    thread_.join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  bool done_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // last: it starts when all else is there
};

// Requires Python's lock. Throws what Python has raised.
void look(WatchedProgress& watched, const py::object& progress) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (progress.is_none()) return;
  if (const auto news = watched.news()) progress(news->first, news->second);
}

}  // namespace

void run_long(const py::object& progress, const std::function<void(common::Progress&)>& work) {
  WatchedProgress watched;
  Worker worker(work, watched);
  const auto ended = [&worker] {
    const py::gil_scoped_release unlocked;
    return worker.ends_within(between_looks);
  };
  try {
    while (!ended()) look(watched, progress);
  } catch (...) {
    watched.stop();
    const py::gil_scoped_release unlocked;
    while (!worker.ends_within(between_looks)) continue;
    throw;
  }
  worker.finish();
  look(watched, progress);
}

int thread_count(int asked) {
  if (asked < 0) throw std::invalid_argument("threads must be 1 or more, or 0 for all processors");
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace kinetostat::python
