// What instruments show that lag behind what they look at.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/regression/predictions.h"
#include "kinetostat/vjm/effects/effect_model.h"

namespace kinetostat::calibration {

/// Whether an instrument may lag behind a component: translations, rotations and distances that are
/// read, none that is set, and no tilt, joint, force or torque.
bool may_lag(const Campaign& campaign, Eigen::Index component);

/// Which of the parameters is that value of an effect.
std::optional<Eigen::Index> column_of(const std::vector<vjm::ModelParameter>& parameters,
                                      std::size_t effect, Eigen::Index value);

/// Adds to predictions of what there is what effects that lag behind show more, along each history
/// of the campaign (histories_of), with derivatives by `parameters` and by the wrench where the
/// predictions have them. In differences a history starts from the state without load, else from
/// its first reading. Readings without a prediction leave it as it was.
void add_lag(const Campaign& campaign, const std::vector<vjm::Effect>& effects,
             const std::vector<vjm::ModelParameter>& parameters, Predictions& predictions);

}  // namespace kinetostat::calibration
