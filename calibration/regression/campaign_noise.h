// The noise of a campaign as far as the robot that was measured has a part in it.
#pragma once

#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// The noise of a campaign: of datums as with_datums_seen() has it, that of the wrenches through
/// the compliance of the robot once what is uncertain has been fitted. Throws what fit_base()
/// throws, when wrenches have noise.
Noise noise_of(const vjm::Robot& robot, const Campaign& campaign, int threads,
               common::Progress& progress);

}  // namespace kinetostat::calibration
