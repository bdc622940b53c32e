// How exact the readings of a campaign are: as stated, else by their repetitions.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/noise.h"
#include "kinetostat/calibration/campaign/replicates.h"

namespace kinetostat::calibration {

Noise noise_of(const Campaign& campaign, const std::vector<ReplicateGroup>& groups);

/// `noise` that is estimated from replicates, with the standard deviation that each kind of
/// component has by them beside what readings of one datum share; the noise of datums that is not
/// stated stays the same multiple of it. Another noise as it is.
Noise with_scatter(Noise noise, const Campaign& campaign,
                   const std::vector<ReplicateGroup>& groups);

}  // namespace kinetostat::calibration
