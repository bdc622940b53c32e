// Readings that effects say are off by a constant, and which they may be.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/regression/predictions.h"
#include "kinetostat/vjm/effects/effect_model.h"

namespace kinetostat::calibration {

/// Of every reading. Sessions and cycles are numbered in the order of Campaign::sessions and of
/// cycles_as_run().
std::vector<vjm::ReadingMoment> moments_of(const Campaign& campaign);

/// Adds to predictions what effects are off that offset readings (EffectKind::offsets_readings),
/// with derivatives by `parameters` where the predictions have them; in the components that may lag
/// (instrument_lag.h).
void add_offsets(const Campaign& campaign, const std::vector<vjm::Effect>& effects,
                 const std::vector<vjm::ModelParameter>& parameters, Predictions& predictions);

/// The effect at all readings that it may name, in the order of time: from a reading of a session
/// on whose readings all have a time, with three at least before and after; each of three or more
/// load cycles with three readings or more. Only readings in use count. Empty where there are none.
std::vector<vjm::Effect> placements(const vjm::Effect& effect, const Campaign& campaign);

}  // namespace kinetostat::calibration
