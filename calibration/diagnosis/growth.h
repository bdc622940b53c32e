// A model that grows by one effect after the other, until nothing more is found.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/diagnosis/found_effect.h"
#include "kinetostat/calibration/search/held_out_refit.h"
#include "kinetostat/calibration/search/search.h"

namespace kinetostat::calibration {

/// A model with effects.
struct Model {
  std::vector<Candidate> present;  // with fitted values
  BaseFit fit;                     // with all of them
  /// With the first of them, the first two, ...; none where that has no fit. The last is `fit`.
  std::vector<std::optional<BaseFit>> stages;
  std::vector<BaseFit> alone;  // of models with one effect, in the order of the first ranking
  BaseFit without;             // of the model before anything was added
};

struct Growth {
  Model model;
  std::vector<FoundEffect> found;  // one for each present effect
  /// Exceeds the detection threshold, but given up, since "nothing is missing" is more probable;
  /// not present.
  std::optional<FoundEffect> doubted;
  std::vector<DiagnosisStep> steps;  // the rounds, in their order
};

/// Adds the best effect of each round as long as one is found (found_effect.h), or a part of what
/// is missing where all of them leave nothing; where none is, looks for two that hide one another;
/// then weighs each of several again beside the others: one that is not needed is dropped, one that
/// is fitted better by something else gives way, and more may be added after that. Where a pair
/// promised more in the first round than what was found explains, the rounds start again from one
/// of it; where an unmodelled smooth error is more probable than what was found, or more is left
/// than its laws may get wrong, from the most significant others of that round, too. One that is
/// left alone, and less probable than that nothing is missing, is given up. `fit`: of the model
/// without anything added, for which `search` has been screened.
Growth grow(const CandidateFitter& fitter, const HeldOutRefit& refit, Search& search,
            const DiagnosisOptions& options, const BaseFit& fit, common::Progress& progress);

/// Log evidence of all effects that were found over that of the unmodelled smooth error in their
/// place, which is put into `instead`. With independent noise: the residual of a wrong effect looks
/// like correlated noise.
double above_free_form(const Model& model, const std::vector<FoundEffect>& found,
                       const Search& search, FreeFormEvidence& instead);

/// Log evidence of an unmodelled smooth error beside a fitted model, whose noise may be correlated.
FreeFormEvidence smooth_error_beside(const BaseFit& fit, const Search& search);

/// fit() of a fitter; none where the model has no equilibrium or no solution.
std::optional<BaseFit> fit_if_possible(const CandidateFitter& fitter,
                                       const std::vector<Candidate>& added, const BaseFit& start,
                                       common::Progress& progress);

}  // namespace kinetostat::calibration
