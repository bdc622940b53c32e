#include "kinetostat/calibration/search/fit_journal.h"

#include <chrono>
#include <thread>
#include <utility>

namespace kinetostat::calibration {

Claim::Claim(FitJournal* journal, std::string item) : journal_(journal), item_(std::move(item)) {}

Claim::~Claim() {
  if (is_held_ && journal_ != nullptr) journal_->give_up(item_);
}

bool Claim::try_once() {
  if (!is_held_) is_held_ = journal_ == nullptr || journal_->claim(item_);
  return is_held_;
}

void Claim::wait(common::Progress& progress) {
  while (!try_once()) {
    progress.report("waiting for another worker", 0);
    wait_a_moment();
  }
}

void wait_a_moment() { std::this_thread::sleep_for(std::chrono::milliseconds(50)); }

}  // namespace kinetostat::calibration
