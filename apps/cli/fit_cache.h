// The fits and signatures of a search for what is missing, kept from one run to the next.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/search/fit_journal.h"
#include "kinetostat/io/cache.h"
#include "kinetostat/io/claims.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// SHA-256 of all that a step with readings depends on: the robot file, the files that it names,
/// the campaign file, its readings, and this build of the program.
std::string inputs_of(const vjm::Robot& robot, const calibration::Campaign& campaign);

class FitCache : public calibration::FitJournal {
 public:
  /// The kept fits belong to the bytes of the robot file, of the files that it names, of the
  /// campaign file and of its readings, and to this build of the program: neither to the number of
  /// threads nor to options, of which those that matter to a fit are part of its own key. `others`:
  /// what the workers that share this search claim; nullptr: it is the only one.
  FitCache(io::Cache cache, const vjm::Robot& robot, const calibration::Campaign& campaign,
           std::function<void(const std::string&)> warn,
           std::unique_ptr<io::Claims> others = nullptr);

  std::optional<std::string> find(const std::string& key) override;
  /// Warns once when the folder cannot be written to, and keeps nothing more.
  void keep(const std::string& key, const std::string& content) override;
  bool claim(const std::string& item) override;
  void give_up(const std::string& item) override;

  /// How much was found, in words, or nothing; the result itself is the same either way.
  std::string what_was_found() const;
  /// The same when the user has stopped the run: how much the next one will find.
  std::string what_is_left() const;

 private:
  io::Cache cache_;
  std::function<void(const std::string&)> warn_;
  std::string scope_;
  int asked_ = 0, found_ = 0;
  std::set<std::string> own_;  // keys of what this run has kept
  bool writable_ = true;
  std::unique_ptr<io::Claims> others_;
};

}  // namespace kinetostat::apps
