// Which readings are off, where an effect is of some readings only.
#pragma once

#include <optional>

#include "kinetostat/calibration/regression/reading_offsets.h"
#include "kinetostat/calibration/search/candidate.h"

namespace kinetostat::calibration {

/// A candidate at the readings where it explains most of what a fit leaves.
struct Placement {
  Candidate candidate;
  Eigen::MatrixXd columns;  // its signature: of all its usual sizes, then of y, z, rx, ry, rz
};

/// Of a candidate that offsets readings (EffectKind::offsets_readings), among all that it may name
/// (reading_offsets.h); of more than 400 every so many first, then those between. nullopt where
/// there are none.
std::optional<Placement> best_placement(const Candidate& candidate, const Campaign& campaign,
                                        const PlatformAxes& axes, const Noise& noise,
                                        const BaseFit& fit);

}  // namespace kinetostat::calibration
