// One round of a diagnosis: the candidates side by side, and what the gate says.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/candidate.h"
#include "kinetostat/calibration/diagnosis/free_form.h"
#include "kinetostat/calibration/diagnosis/gate.h"

namespace kinetostat::calibration {

inline constexpr double outlying = 5;         // standard deviations, of an outlier
inline constexpr double told_apart_from = 4;  // d' that names an effect against a rival
inline constexpr double doubtful = 4.6;       // difference of log evidence below which both remain
/// The same for an effect and the free-form rival, which is all that the catalogue lacks: 1 : 20.
inline constexpr double doubtful_beside_free_form = 3;
/// Below this, that rival is the likelier one.
inline constexpr double beaten_by_free_form = 0;
/// Share of what an effect does that its law may get wrong: laws are idealisations.
inline constexpr double law_error = 0.1;
inline constexpr double unusual = 9;  // times the usual size of an effect: nobody has seen one

/// Why readings do not show what is not one of their unknowns but acts as those do.
inline constexpr const char* absorbed =
    "what it does, the refitted parameters do just as well in these readings";

/// By how much log evidence makes a rival more probable. Laws are idealisations, so what tells near
/// relatives apart is in part what none of them gets right: this much of it is believed (a
/// generalised posterior; Gruenwald and van Ommen, Bayesian Analysis 12, 2017). It has the largest
/// log score over the campaigns of tests/twin; with 1, of the effects that were stated to be 80 to
/// 90 % probable in the first of them, less than half were the hidden ones.
inline constexpr double learning_rate = 0.6;

/// A model with one effect more, fitted.
struct RivalFit {
  Eigen::VectorXd values, deviations;  // of the effect [SI]; NaN where a bound holds a value
  double squared_error = 0;            // whitened
  Eigen::Index degrees_of_freedom = 0;
  double log_score_gain = 0;       // held-out log score beside the model without it
  double log_score_deviation = 0;  // standard error of that paired difference
  /// Every kind is as likely as the others, and so are its places, and its designs at each.
  double log_prior = 0;
  double log_evidence = 0;  // (evidence.h) with that prior; up to a constant of the step
  double probability = 0;   // among the rivals that were fitted and the free-form one
  /// d' of the best one's mark that this one cannot imitate; of the best one, of all its mark.
  double told_apart = 0;
};

/// One row of the ranking: a candidate, and how it fared.
struct Rival {
  Candidate candidate;
  double detectability = 0;       // d' at its usual size, after the fit has absorbed what it can
  double most_detectability = 0;  // the same at whichever size, to the usual one, shows most
  double surprise = 0;            // -log p of its score
  std::string unobservable;       // why these readings cannot show it; empty when they can
  std::optional<RivalFit> fit;
  bool imitates = false;   // not fitted, yet its mark is that of the best
  std::string not_fitted;  // why there is no fit of a candidate that passed the screen
};

/// One round: what is missing beside what was found before?
struct DiagnosisStep {
  std::vector<std::string> beside;  // effects that are in the model already
  Gate gate;                        // under the likeliest noise
  std::vector<Rival> ranking;       // most probable first, then by surprise, then unobservable ones
  std::vector<std::size_t> indistinguishable;  // in the ranking: the best and what may be it
  double log_evidence_without = 0;             // of the model as it is, nothing missing
  double squared_error_without = 0;            // whitened, of the same
  FreeFormEvidence free_form;  // beside that and its noise; as likely beforehand as a kind
  double free_form_probability = 0;
  /// The most surprising candidates, and the largest cosine of a mark of the one with one of the
  /// other: 1 where the one does what the other does.
  std::vector<std::string> confused;
  Eigen::MatrixXd confusion;
};

/// How many times its usual size a fitted effect has: the value for which that is most.
double times_usual(const Rival& rival);

}  // namespace kinetostat::calibration
