// Parameters that were declared uncertain, but are not identifiable from the readings at hand.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/regression/predict.h"

namespace kinetostat::calibration {

/// Fixes at its start each parameter that no reading depends on, or that is confounded with those
/// before it to within the noise: predictions are the same without it. Returns which, in sentences.
/// A model without an equilibrium for some reading keeps them all free.
std::vector<std::string> keep_undetermined(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise, std::vector<Parameter>& parameters,
                                           common::Progress& progress);

}  // namespace kinetostat::calibration
