// Readings that are a multiple of what the model predicts: a slip in a unit or a sign.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/progress.h"

namespace kinetostat::calibration {

/// In a sentence what looks like a slip: readings in the pattern of the predictions, but more than
/// eight times as large, less than an eighth, or against them. Empty where there is none.
/// Translations and rotations each by themselves, without their means over a session, which zeros
/// and frames move. `predicted`: by the model as designed, one a reading [m; rad].
std::string unit_slip(const Campaign& campaign, const std::vector<spatial::Vector6>& predicted);

/// Predicted by the robot as its file has it; empty, too, where that has no equilibrium.
std::string unit_slip(const Campaign& campaign, const Predictor& as_designed,
                      common::Progress& progress);

/// What `fit` returns; where it finds no end, its error says as well what looks like a slip.
/// `as_designed`: of the robot as its file has it, for the same campaign.
template <class Fit>
auto with_hint_of_slip(const Predictor& as_designed, const Campaign& campaign,
                       common::Progress& progress, const Fit& fit) {
  try {
    return fit();
  } catch (const common::NoConvergence& error) {
    const std::string slip = unit_slip(campaign, as_designed, progress);
    if (slip.empty()) throw;
    throw common::NoConvergence(std::string(error.what()) + ". " + slip);
  }
}

}  // namespace kinetostat::calibration
