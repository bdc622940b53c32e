// The candidates that readings so far leave open, by a diagnosis of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/diagnosis_record.h"
#include "kinetostat/calibration/search/candidate.h"

namespace kinetostat::calibration {

/// Something that may be missing.
struct OpenCandidate {
  Candidate candidate;  // with fitted values, or of its usual size
  bool is_fitted = false;
  double probability = 0;                   // among the candidates; 0: not known
  std::optional<double> log_evidence = {};  // up to a constant that the candidates share
};

struct PlanQuestion {
  std::vector<Candidate> present = {};   // what was found and is not in doubt
  std::vector<OpenCandidate> open = {};  // what may be missing beside that
  bool perhaps_nothing = false;          // that nothing is missing is a candidate, too
  double nothing = 0;                    // probability of that; 0: not known
  /// Probability that it is in the catalogue at all, after a diagnosis that leaves it unexplained.
  double in_catalogue = 1;
  /// Where the candidates were asked for: further effects that are not observable in the readings
  /// so far, each of its usual size. New readings that show the candidates may show these, too, and
  /// must distinguish them.
  std::vector<Candidate> unseen = {};
  std::string verdict = {};  // of the diagnosis
};

/// The question that a result of `diagnose` leaves: its ambiguous set; what it doubts, where
/// nothing is needed; where it is inconclusive, the effects that were not observable, one place of
/// each kind; where nothing explains the readings, the nearest candidates; else no candidates.
/// `show`: effects (or "effect at place") that the next readings shall show, whatever was found.
/// Throws common::InputError when the diagnosis is of another robot, std::invalid_argument for an
/// effect that the robot cannot have.
PlanQuestion question_of(const vjm::Robot& robot, const DiagnosisRecord& diagnosis,
                         const std::vector<std::string>& show);

}  // namespace kinetostat::calibration
