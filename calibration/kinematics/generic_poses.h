// What kinematics leave redundant whatever is measured.
#pragma once

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/kinematics/geometric_parameter.h"
#include "kinetostat/calibration/kinematics/identifiable.h"
#include "kinetostat/common/progress.h"

namespace kinetostat::calibration {

/// Which geometric parameters whole poses of the platform distinguish, exactly read at random
/// postures over the ranges of the joints (home +- 2 rad or 0.3 of the reach where no range is
/// stated) of a serial robot; of others at the postures of the campaign, since random ones do not
/// close their loops. The measuring frame is unknown where the campaign says so. All parameters are
/// kept where a posture has no equilibrium, or the campaign does not read the platform.
IndependentColumns generically_independent(const vjm::Robot& robot, const GeometricModel& model,
                                           const Campaign& campaign, double reach, int threads,
                                           common::Progress& progress);

}  // namespace kinetostat::calibration
