#include "kinetostat/apps/cli/fit_cache.h"

#include <fmt/format.h>

#include "kinetostat/apps/cli/version.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::apps {
namespace {

std::string scope_of(const vjm::Robot& robot, const calibration::Campaign& campaign) {
  std::string scope = "fit " + this_program();
  const auto add = [&scope](const std::filesystem::path& file) {
    scope += " " + io::sha256(io::read_text(file));
  };
  add(robot.file);
  for (const std::filesystem::path& file : robot.link_files) add(file);
  add(campaign.file);
  add(campaign.readings_file);
  return scope;
}

}  // namespace

std::string inputs_of(const vjm::Robot& robot, const calibration::Campaign& campaign) {
  return io::sha256(scope_of(robot, campaign));
}

FitCache::FitCache(io::Cache cache, const vjm::Robot& robot, const calibration::Campaign& campaign,
                   std::function<void(const std::string&)> warn, std::unique_ptr<io::Claims> others)
    : cache_(std::move(cache)),
      warn_(std::move(warn)),
      scope_(cache_.enabled() ? scope_of(robot, campaign) : ""),
      others_(std::move(others)) {}

std::optional<std::string> FitCache::find(const std::string& key) {
  ++asked_;
  std::optional<std::string> content = cache_.find(scope_ + key);
  // A search may ask for the same twice.
  found_ += content && !own_.contains(key) ? 1 : 0;
  return content;
}

void FitCache::keep(const std::string& key, const std::string& content) {
  if (!writable_ || !cache_.enabled()) return;
  writable_ = cache_.keep(scope_ + key, content);
  if (writable_) {
    own_.insert(key);
    return;
  }
  warn_(
      fmt::format("the cache folder {} cannot be written to, or its disk is full: if this "
                  "run is interrupted, the next one cannot go on from there",
                  cache_.folder().string()));
}

bool FitCache::claim(const std::string& item) {
  return others_ == nullptr || others_->claim(scope_ + item);
}

void FitCache::give_up(const std::string& item) {
  if (others_ != nullptr) others_->give_up(scope_ + item);
}

std::string FitCache::what_was_found() const {
  if (found_ == 0) return {};
  return fmt::format("{} of {} fits and signatures from the cache", found_, asked_);
}

std::string FitCache::what_is_left() const {
  const std::size_t there = own_.size() + static_cast<std::size_t>(found_);
  if (there == 0) return {};
  return fmt::format(
      "{} fits and signatures are in the cache: ask again, and it goes on from there", there);
}

}  // namespace kinetostat::apps
