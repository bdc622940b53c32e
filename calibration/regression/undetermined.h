// What was declared uncertain, but is not determined by the readings at hand.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/regression/predict.h"

namespace kinetostat::calibration {

/// Fixes each parameter where it starts that no reading depends on, or that does to all readings
/// what those before it do, as far as their noise can show: predictions are the same without it.
/// Returns which, in sentences. A model without an equilibrium for some reading keeps them all
/// free.
std::vector<std::string> keep_undetermined(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise, std::vector<Parameter>& parameters,
                                           common::Progress& progress);

}  // namespace kinetostat::calibration
