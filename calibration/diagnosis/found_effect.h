// An effect that was found, by what the round that looked for it says.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/decision.h"

namespace kinetostat::calibration {

inline constexpr double unexplained_share = 0.3;  // of the misfit: more is another effect

inline constexpr double level_of_rest = 0.005;  // of a rest that no effect explains

/// An effect that was found.
struct FoundEffect {
  Candidate candidate;  // with the fitted values
  Eigen::VectorXd deviations;
  Decision decision;       // of the round that looked for it beside the others
  double probability = 0;  // of its answer there: its class at its place, or places
  double false_alarm_chance = 1;
  double log_prior = 0;                 // of kind and place
  double times_usual = 0;               // how large it is
  double length = 0;                    // of its signature, in units of the noise
  double log_score_gain = 0;            // on held-out readings, beside the others
  std::vector<Candidate> instead = {};  // what it may be instead: a law of each other answer
};

/// What the best of a round is.
enum class Finding {
  nothing,
  part,   // of what is missing: an unmodelled smooth error does better
  effect  // that was found
};

/// A found effect exceeds the detection threshold (the first one comes near it), and improves the
/// prediction of readings that it was not fitted to or is far more probable than no missing effect.
/// Beside another effect it must do both and have a higher significance; where it is less likely
/// than an unmodelled smooth error, it may be one of several that are still missing.
Finding finding(const DiagnosisStep& step, const std::vector<FoundEffect>& found);

/// The best of a round is so large that nobody has seen one, and no better than an unmodelled
/// smooth error, or it leaves much of the misfit.
bool is_absurd(const DiagnosisStep& step);

/// The length of what the laws of those that were found may get wrong, where that looks like the
/// best of a round beside them: more of it where both act at one joint, or follow time or
/// temperature. A law that is wrong by a share of what it does to each reading looks like something
/// that acts on other readings by no more than that share of what they have in common (Hoelder).
double law_error_like(const std::vector<FoundEffect>& found, const DiagnosisStep& step);

/// The last round beside these and no others; null where there was none.
const DiagnosisStep* round_beside(std::span<const FoundEffect> found,
                                  const std::vector<DiagnosisStep>& steps);
/// Its best is no more than what the laws of those that were found may get wrong.
bool is_rest_of_laws(const std::vector<FoundEffect>& found, const DiagnosisStep& step);

/// The best of a round.
FoundEffect found_effect(const DiagnosisStep& step);
/// What a round beside all the other effects says of one that was found earlier; where it was not
/// fitted there, what was decided before stands.
void confirm(const DiagnosisStep& step, FoundEffect& found);
/// Something fits better beside the others than the one that was found, and is decidedly likelier,
/// or likelier at all where it is another law of the same answer.
/// `squared_error`: of the model with it, for the round may not have fitted it.
bool is_replaced(const DiagnosisStep& step, const FoundEffect& found, double squared_error);
/// The fit of one that was found, in a round; none where it was not fitted there.
const CandidateFit* fit_of(const DiagnosisStep& step, const FoundEffect& found);

}  // namespace kinetostat::calibration
