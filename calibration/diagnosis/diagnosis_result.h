// What a diagnosis found.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/comparison/waterfall.h"
#include "kinetostat/calibration/diagnosis/common_cause.h"
#include "kinetostat/calibration/diagnosis/found_effect.h"
#include "kinetostat/calibration/diagnosis/profile.h"
#include "kinetostat/calibration/diagnosis/verdict.h"
#include "kinetostat/calibration/regression/correlation.h"
#include "kinetostat/calibration/search/diagnosis_step.h"
#include "kinetostat/calibration/search/free_form.h"
#include "kinetostat/calibration/search/signature_table.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {

inline constexpr double structure_level = 0.01;  // of an unmodelled smooth error, in what is left

struct Diagnosis {
  Verdict verdict = Verdict::inconclusive;
  std::vector<FoundEffect> found;      // in the order of their finding
  std::vector<std::string> ambiguous;  // where one may be something else: itself, then the others
  /// What may be missing all the same, where nothing is needed; see Growth::doubted.
  std::optional<FoundEffect> doubted;
  /// Where nothing was found: the one cause that fitted parameters may stand for.
  std::optional<CommonCause> common_cause;
  std::vector<std::string> missing;  // what readings would have to have, in sentences
  /// Share of the misfit that geometric errors of all joints and links explain together, where no
  /// effect alone does; nothing below one half.
  std::optional<double> by_kinematics;
  std::vector<std::string> set_aside;  // readings that no candidate explains, with reasons
  /// Values that no candidate explains, where they are too many to be set aside.
  std::size_t far_values = 0;
  std::vector<DiagnosisStep> steps;
  std::vector<KindWithoutPlace> without_place;  // kinds that could not be tried
  std::vector<std::string> weak;                // combinations that the base fit hardly knows
  NoiseSource noise = NoiseSource::unknown;
  bool noise_without_load = false;  // only readings without load are repeated, and none is stated
  std::optional<ChiSquareTest> before, after;  // of the base fit, and with what was found
  /// Scatter of repeated readings against the stated noise, when both exist.
  std::optional<ChiSquareTest> noise_check;
  /// How the noise of the readings is not independent, beside all that was found; else empty.
  std::string correlated_noise;
  /// Reduced chi-square with what was found, of readings whose noise is shared as far as they show.
  double misfit = 0;
  /// What readings share is part of that, and is said with `correlated_noise`.
  bool shares_noise() const { return after && misfit < after->reduced(); }
  std::string unit_error;  // unit error or sign error that the readings look like; else empty
  /// Evidence of an unmodelled smooth error: instead of the effects found, and in the residual
  /// beside them.
  FreeFormEvidence free_form, left;
  /// Log evidence of all that was found over that of the unmodelled smooth error instead.
  double above_free_form = 0;
  /// No stated noise is so wrong that it would account for what is left.
  bool is_left_open() const;
  /// p-value of the max-statistic test beside all effects that were found: where it is small, no
  /// effect explains the rest.
  double rest_p_value = 1;
  /// The candidate most like that rest, where the rest is no more than the error of the laws that
  /// were found.
  std::string rest_of_laws;
  /// Noise as stated would hardly leave as much as is left with all that was found.
  bool leaves_misfit() const;
  /// Some effect that was found does not help to predict held-out readings.
  bool predicts_no_better() const;
  /// With some effect that was found the error of the waterfall does not fall, as adopting asks.
  bool predicts_worse() const;
  bool or_something_else = false;  // that the catalogue lacks, may be what is missing
  std::vector<WaterfallStage> waterfall;
  /// What the robot file declares uncertain, fitted to the readings without any effect added, and
  /// beside all that was found.
  std::vector<ParameterEstimate> fitted_without, fitted_beside;
  /// Of these; `beside` with the values of what was found.
  EstimateCorrelation correlation_without, correlation_beside;
  std::string held_out;  // what was left out together: "configurations"
  std::vector<Profile> profiles;
  std::optional<SignatureTable> signatures;  // of the first round, where asked for
};

/// A kind of effect that is not observable at its usual size, wherever it is (d' below that which
/// names an effect), or that has no place.
struct UnseenKind {
  std::string name;
  double detectability = 0;          // d' at its best place
  bool confounded_with_fit = false;  // the fitted parameters do the same
  std::string reason = {};           // why it has no place; else empty
};
/// Unseen kinds of the first round, by name.
std::vector<UnseenKind> unseen_kinds(const Diagnosis& diagnosis);

}  // namespace kinetostat::calibration
