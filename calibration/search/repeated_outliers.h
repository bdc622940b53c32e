// Outliers that come back whenever the robot is loaded so are none.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// Of values that were taken for outliers those that may be: not four or more of one component that
/// are off to one side (`residual`, one a value) under loads along one line, and are half or more
/// of all values of that component under such loads. Slips of the pen know nothing of the load.
std::vector<std::size_t> without_repeated(const Campaign& campaign,
                                          const std::vector<Value>& values,
                                          const Eigen::VectorXd& residual,
                                          const std::vector<std::size_t>& outliers);

}  // namespace kinetostat::calibration
