// Which readings are off, where an effect is of some readings only.
#pragma once

#include <vector>

#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/calibration/search/candidate.h"

namespace kinetostat::calibration {

/// A candidate at the readings where it explains most of what a fit leaves.
struct Placement {
  Candidate candidate;
  Eigen::MatrixXd columns;  // its signature: of all its usual sizes, then of y, z, rx, ry, rz
};

/// Of a candidate that offsets readings (EffectKind::offsets_readings), among all that it may name
/// (reading_offsets.h); of more than 400 every so many first, then those between. Up to two more
/// follow, each of which explains most of what those before it leave, and far more than noise
/// would: a target may slip twice. Empty where there are none.
std::vector<Placement> best_placements(const Candidate& candidate, const Campaign& campaign,
                                       const PlatformAxes& axes, const Noise& noise,
                                       const BaseFit& fit);

}  // namespace kinetostat::calibration
