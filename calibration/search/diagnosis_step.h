// One round of a diagnosis: the candidates side by side, and the max-statistic test.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/search/candidate.h"
#include "kinetostat/calibration/search/free_form.h"
#include "kinetostat/calibration/search/max_score_test.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {

inline constexpr double discriminable_from = 4;  // d' that names an effect against a candidate
inline constexpr double doubtful = 4.6;  // difference of log evidence below which both remain
/// The same for an effect and the unmodelled smooth error, which stands for all that the catalogue
/// lacks: odds 1 : 20.
inline constexpr double doubtful_beside_free_form = 3;
/// Below this, the unmodelled smooth error is the likelier one.
inline constexpr double beaten_by_free_form = 0;
/// Share of what an effect does that its law may get wrong: laws are idealisations.
inline constexpr double law_error = 0.1;
/// The same of an exact law: of the robot about it, and of the readings.
inline constexpr double error_of_exact_law = 0.02;
inline constexpr double unusual = 9;  // times the usual size of an effect: nobody has seen one

inline constexpr double believable_noise = 2;  // times the stated one, to account for a misfit

/// Reason why an effect that acts as the fitted parameters do is not observable.
inline constexpr const char* confounded_with_fit =
    "it is confounded with the fitted parameters in these readings";

/// Learning rate eta of a generalised posterior (Gruenwald and van Ommen, Bayesian Analysis 12,
/// 2017):
///
///   P_c = exp(eta L_c) / (exp(eta L_0) + sum over j of exp(eta L_j))
///   L_c = log evidence of the fit + log_prior + gain by correlated noise
///   L_0 = log evidence of the fit with nothing added + that of the unmodelled smooth error
///
/// Laws are idealisations: the difference between near relatives is in part an error of both. This
/// eta has the largest log score over the campaigns of tests/twin. With eta = 1, less than half of
/// the effects that were stated to be 80 to 90 % probable in the first of them were the hidden
/// ones.
inline constexpr double learning_rate = 0.6;

/// A model with one effect more, fitted.
struct CandidateFit {
  Eigen::VectorXd values, deviations;  // of the effect [SI]; NaN where a bound holds a value
  double squared_error = 0;            // whitened
  Eigen::Index degrees_of_freedom = 0;
  double log_score_gain = 0;       // held-out log score beside the model without it
  double log_score_deviation = 0;  // standard error of that paired difference
  /// -ln(places of its kind * designs at each): every kind is as likely as the others, and so are
  /// its places, and its designs at each.
  double log_prior = 0;
  double log_evidence = 0;  // (evidence.h) with that prior; up to a constant of the step
  double probability = 0;   // among the candidates that were fitted and the unmodelled smooth error
  /// d' = min(|N_c s|, |r_best - r_c|) of the best candidate against this one, where s = r_best -
  /// r_0 is the signature of the best, r are whitened residuals (r_0: nothing added), and N_c
  /// projects on the complement of what the fit of this one can produce. |s| for the best itself.
  double discriminability = 0;
};

/// One row of the ranking: a candidate, and how it fared.
struct RankedCandidate {
  Candidate candidate;
  double detectability = 0;       // d' at its usual size, beside the fitted parameters
  double most_detectability = 0;  // the same at whichever size, to the usual one, shows most
  double significance = 0;        // -ln p of its score
  std::string unobservable;       // why these readings cannot show it; empty when they can
  std::optional<CandidateFit> fit;
  /// Not fitted, yet confounded with the best: squared error that it leaves beyond that, at least.
  std::optional<double> falls_short = {};
  std::string not_fitted;  // why there is no fit of a candidate that passed the screen
  /// Not fitted: others leave nothing but noise, and it promises to leave far more. The odds
  /// against it are more than 10^12.
  bool is_hopeless = false;
};

/// Two candidates that explain much together.
struct CandidatePair {
  std::array<std::string, 2> names;
  double explained = 0;      // of the squared residual, to first order
  Eigen::Index columns = 0;  // with which
};

/// One round: what is missing beside what was found before?
struct DiagnosisStep {
  std::vector<std::string> beside;  // effects that are in the model already
  MaxScoreTest max_score;           // under the likeliest noise
  /// How far the best acts on the readings that each of those beside it acts on: the sum of
  /// |a_i| |b_i| over the lengths of what a and b do to them. Empty: not known.
  std::vector<double> shared = {};
  bool takes_rest_for_noise = false;  // that noise is correlated, as what is missing may be
  /// Most probable first, then by significance, then unobservable ones.
  std::vector<RankedCandidate> ranking;
  std::vector<CandidatePair> pairs = {};       // of the first round: those that promise most
  std::vector<std::size_t> indistinguishable;  // in the ranking: the best and what may be it
  double log_evidence_without = 0;             // of the model as it is, nothing missing
  double squared_error_without = 0;            // whitened, of the same
  double share_left = 0;                       // of the misfit, by the best; see CorrelatedNoise
  FreeFormEvidence free_form;  // beside that and its noise; as likely beforehand as a kind
  double free_form_probability = 0;
  /// The most significant candidates, and the largest cosine between a signature of the one and a
  /// signature of the other: 1 where they are the same direction.
  std::vector<std::string> confused;
  Eigen::MatrixXd confusion;

  /// Whether candidates are fitted. For the first effect the evidence decides; further ones must
  /// be significant, too.
  bool is_worth_a_look() const {
    return max_score.p_value <= (beside.empty() ? worth_a_look : significance_level);
  }
};

/// How many times its usual size a fitted effect has.
double times_usual(const RankedCandidate& ranked);

}  // namespace kinetostat::calibration
