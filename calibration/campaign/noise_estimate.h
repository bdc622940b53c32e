// How exact the readings of a campaign are: as stated, else by their repetitions.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/campaign/replicates.h"

namespace kinetostat::calibration {

Noise noise_of(const Campaign& campaign, const std::vector<ReplicateGroup>& groups);

}  // namespace kinetostat::calibration
