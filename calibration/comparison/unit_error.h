// Readings that are a multiple of the predictions, or in another frame: errors of units and signs,
// an instrument that stands elsewhere.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/regression/predict.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/progress.h"

namespace kinetostat::calibration {

/// Sentence about a suspected unit error or sign error: readings in the pattern of the predictions,
/// but more than eight times as large, less than an eighth, or of opposite sign. Empty where there
/// is none. Translations and rotations each by themselves, without their means over a session,
/// which zero offsets and frames move. Likewise about absolute positions that are off by more than
/// a centimetre, where one rigid motion takes nine tenths of that. `predicted`: by the nominal
/// model, one a reading [m; rad].
std::string unit_error(const Campaign& campaign, const std::vector<Eigen::VectorXd>& predicted);

/// Sentence about rotations in arc seconds for microradians, or the other way, beside translations
/// that are as predicted: no stiffness makes one without the other. Empty where they are not.
std::string rotation_unit_error(const Campaign& campaign,
                                const std::vector<Eigen::VectorXd>& predicted);

/// The same as unit_error() with predictions of the nominal robot; empty, too, where that has no
/// equilibrium.
std::string unit_error(const Campaign& campaign, const Predictor& nominal,
                       common::Progress& progress);

/// The result of `fit`; where it does not converge, its error also names a suspected unit or sign
/// error. `nominal`: predictor of the robot as its file has it, for the same campaign.
template <class Fit>
auto with_hint_of_unit_error(const Predictor& nominal, const Campaign& campaign,
                             common::Progress& progress, const Fit& fit) {
  try {
    return fit();
  } catch (const common::NoConvergence& error) {
    const std::string slip = unit_error(campaign, nominal, progress);
    if (slip.empty()) throw;
    throw common::NoConvergence(std::string(error.what()) + ". " + slip);
  } catch (const common::NotIdentifiable& error) {
    const std::string slip = unit_error(campaign, nominal, progress);
    if (slip.empty()) throw;
    throw common::NotIdentifiable(slip + " As it is, " + error.what());
  }
}

}  // namespace kinetostat::calibration
