// Likelihood profiles: how much worse every model with another value of one parameter is.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/search/candidate_fitter.h"

namespace kinetostat::calibration {

struct ProfilePoint {
  double value = 0;  // of the coordinate
  /// Rise of the cost (penalised_error()) above that of the best fit, with all other unknowns
  /// fitted again. About ((value - best) / deviation)^2 where the model is as good as linear.
  double rise = 0;
};

struct Profile {
  ParameterEstimate estimate;        // at the best fit
  std::vector<ProfilePoint> points;  // ascending; the best fit among them
  /// Where the rise is 3.84, by interpolation: 95 % of the likelihood-ratio test with one degree of
  /// freedom (Venzon and Moolgavkar 1988). Nothing on a side where the points end before.
  std::array<std::optional<double>, 2> interval;
  std::string ended;  // why there are no points, or none further out, on a side; else empty
};

/// Profiles of the values of `added`, then of the uncertain parameters, at most `most` together:
/// twelve points each, to three standard deviations on both sides or to the bounds. `best`: the fit
/// of `fitter` with `added`. Each point costs a fit, started at its neighbour.
std::vector<Profile> profiles(const CandidateFitter& fitter, const std::vector<Candidate>& added,
                              const BaseFit& best, std::size_t most, common::Progress& progress);

}  // namespace kinetostat::calibration
