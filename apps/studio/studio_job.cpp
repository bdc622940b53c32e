#include "kinetostat/apps/studio/studio_job.h"

#include <new>

namespace kinetostat::apps {

StudioJob::~StudioJob() {
  stop();
  if (thread_.joinable()) thread_.join();
}

bool StudioJob::start(const std::string& name, Work work) {
  {
    const std::scoped_lock lock(mutex_);
    if (status_["running"].get<bool>()) return false;
    status_ = {{"job", name},   {"running", true}, {"phase", ""},
               {"fraction", 0}, {"seconds", 0},    {"found", io::Json::array()}};
    begin_ = std::chrono::steady_clock::now();
  }
  if (thread_.joinable()) thread_.join();
  stopped_ = false;
  thread_ = std::thread([this, work = std::move(work)] { run(work); });
  return true;
}

bool StudioJob::runs() const {
  const std::scoped_lock lock(mutex_);
  return status_["running"].get<bool>();
}

io::Json StudioJob::status() const {
  const std::scoped_lock lock(mutex_);
  io::Json status = status_;
  if (status["running"].get<bool>())
    status["seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  return status;
}

void StudioJob::say(const std::string& sentence) {
  const std::scoped_lock lock(mutex_);
  status_["found"].push_back(sentence);
}

void StudioJob::show(std::string_view phase, double fraction) {
  const std::scoped_lock lock(mutex_);
  status_["phase"] = phase;
  status_["fraction"] = fraction;
}

void StudioJob::run(const Work& work) {
  io::Json end;
  try {
    end = {{"result", work(*this)}};
  } catch (const common::Cancelled&) {
    end = {{"error", "stopped"}};
  } catch (const std::bad_alloc&) {
    end = {{"error", "there is not enough memory for this: close other programs"}};
  } catch (const std::exception& error) {
    end = {{"error", error.what()}};
  }
  const std::scoped_lock lock(mutex_);
  status_.update(end);
  status_["running"] = false;
}

}  // namespace kinetostat::apps
