// Which physical effect is missing from a model?
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetostat/calibration/gate.h"
#include "kinetostat/calibration/goodness_of_fit.h"
#include "kinetostat/calibration/profile.h"
#include "kinetostat/calibration/structure.h"
#include "kinetostat/calibration/waterfall.h"

namespace kinetostat::calibration {

struct DiagnosisOptions {
  std::vector<std::string> kinds;  // of effects that are tried; empty: the whole catalogue
  int draws = 500;                 // of the bootstraps
  std::uint64_t seed = 1;
  std::size_t most_effects = 3;  // that are named one after the other
  std::size_t profiles = 0;      // most likelihood profiles of the final model
};

/// A model with one effect more, fitted.
struct RivalFit {
  Eigen::VectorXd values, deviations;  // of the effect [SI]; NaN where a bound holds a value
  double squared_error = 0;            // whitened
  Eigen::Index degrees_of_freedom = 0;
  double log_score_gain = 0;       // held-out log score beside the model without it
  double log_score_deviation = 0;  // standard error of that paired difference
  double log_evidence = 0;         // Laplace, tempered, up to a constant of the step
  double probability = 0;          // among the rivals that were fitted
  double told_apart = 0;           // d' of the best one's mark that this one cannot imitate
};

/// One row of the ranking: a candidate, and how it fared.
struct Rival {
  Candidate candidate;
  double detectability = 0;  // d' at its usual size, after the fit has absorbed what it can
  double surprise = 0;       // -log p of its score
  std::string unobservable;  // why these readings cannot show it; empty when they can
  std::optional<RivalFit> fit;
  bool imitates = false;   // not fitted, yet its mark is that of the best
  std::string not_fitted;  // why there is no fit of a candidate that passed the screen
};

/// One round: what is missing beside what was found before?
struct DiagnosisStep {
  std::vector<std::string> beside;  // effects that are in the model already
  Gate gate;
  std::vector<Rival> ranking;  // most probable first, then by surprise, then unobservable ones
  std::vector<std::size_t> indistinguishable;  // in the ranking: the best and what may be it
  /// The most surprising candidates, and the largest cosine of a mark of the one with one of the
  /// other: 1 where the one does what the other does.
  std::vector<std::string> confused;
  Eigen::MatrixXd confusion;
};

enum class Verdict { no_effect_needed, named_effect, ambiguous, none_of_the_above, cannot_tell };
std::string to_string(Verdict verdict);

/// An effect that was found.
struct FoundEffect {
  Candidate candidate;  // with the fitted values
  Eigen::VectorXd deviations;
  double probability = 0;  // among the rivals, beside the other effects that were found
  double gate_p_value = 1;
  std::vector<std::string> instead = {};  // what it may be instead
};

struct Diagnosis {
  Verdict verdict = Verdict::cannot_tell;
  std::vector<FoundEffect> found;      // in the order of their finding
  std::vector<std::string> ambiguous;  // where one may be something else: itself, then the others
  std::vector<std::string> missing;    // what readings would have to have, in sentences
  std::vector<std::string> set_aside;  // readings that no candidate explains, with reasons
  std::vector<DiagnosisStep> steps;
  std::vector<std::string> weak;  // combinations that the base fit hardly knows
  NoiseSource noise = NoiseSource::unknown;
  std::optional<ChiSquareTest> before, after;  // of the base fit, and with what was found
  StructureTest structure;                     // of what is left at the end
  std::vector<WaterfallStage> waterfall;
  std::string held_out;  // what was left out together: "configurations"
  std::vector<Profile> profiles;
};

/// Refits what is uncertain under every rival, screens all candidates with score tests, passes a
/// gate that knows how many were tried, fits what survives with the full model, ranks by evidence,
/// and names an effect only when the readings tell it from every rival. `robot` and `campaign` as
/// read. Throws what fit_base() throws for the model as it stands.
Diagnosis diagnose(const vjm::Robot& robot, const Campaign& campaign,
                   const DiagnosisOptions& options, int threads, files::Progress& progress);

}  // namespace kinetostat::calibration
