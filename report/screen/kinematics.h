// First screen of `calibrate`.
#pragma once

#include <string>

#include "kinetostat/calibration/kinematics/kinematic_calibration.h"

namespace kinetostat::report {

/// "Kinematics calibrated: 0.45 -> 0.23 mm rms at poses that were held out (27 of 30 parameters; 3
/// cannot be distinguished in these poses)."
std::string headline(const calibration::Campaign& campaign,
                     const calibration::KinematicCalibration& calibration);
/// Headline, the falling error, the largest corrections, what was left out. `next`: the last lines.
std::string first_screen(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const calibration::KinematicCalibration& calibration,
                         const std::string& next);

}  // namespace kinetostat::report
