// What readings so far leave open, as far as a diagnosis tells.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/candidate.h"
#include "kinetostat/io/json.h"

namespace kinetostat::calibration {

/// Something that may be missing.
struct Suspect {
  Candidate candidate;  // with fitted values, or of its usual size
  bool is_fitted = false;
  double probability = 0;                   // among its rivals; 0: not known
  std::optional<double> log_evidence = {};  // up to a constant that its rivals share
};

struct PlanQuestion {
  std::vector<Candidate> present = {};  // what was found and is not in doubt
  std::vector<Suspect> suspects = {};   // what may be missing beside that
  bool perhaps_nothing = false;         // that nothing is missing is a rival, too
  /// Where the suspects were asked for: what else readings so far do not show, each of its usual
  /// size. New readings that show the suspects may show these, too, and must not mix them up.
  std::vector<Candidate> unseen = {};
  std::string verdict = {};  // of the diagnosis
};

/// From what `diagnose` writes: its ambiguous set; where the data cannot tell, what they could not
/// show, one place of each kind; where nothing explains them, the nearest rivals; else no suspects.
/// `show`: effects (or "effect at place") that the next readings shall show, whatever was found.
/// `file` is for messages. Throws common::InputError when the file is of another robot,
/// std::invalid_argument for an effect that the robot cannot have.
PlanQuestion question_of(const vjm::Robot& robot, const io::Json& diagnosis,
                         const std::filesystem::path& file, const std::vector<std::string>& show);

}  // namespace kinetostat::calibration
