// Long work of a studio, in a thread of its own: its page asks how far it is, and may stop it.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "kinetostat/common/progress.h"
#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// One job at a time; what the last one gave stays until the next starts.
class StudioJob : public common::Progress {
 public:
  using Work = std::function<io::Json(common::Progress&)>;

  /// Stops the job and waits for its end.
  ~StudioJob() override;

  /// False where one runs.
  bool start(const std::string& name, Work work);
  void stop() { stopped_ = true; }
  bool runs() const;
  /// {"job", "running", "phase", "fraction", "seconds", "found": what it said on its way, and in
  /// the end "result" or "error"}; {"running": false} before the first.
  io::Json status() const;
  /// Adds a sentence to "found".
  void say(const std::string& sentence);

  bool cancelled() const override { return stopped_; }

 private:
  void show(std::string_view phase, double fraction) override;
  void run(const Work& work);

  mutable std::mutex mutex_;
  io::Json status_ = {{"running", false}};
  std::chrono::steady_clock::time_point begin_;
  std::atomic<bool> stopped_ = false;
  std::thread thread_;
};

}  // namespace kinetostat::apps
