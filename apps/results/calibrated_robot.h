// What a kinematic calibration writes: a robot file with the geometry that was found.
#pragma once

#include <string>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/kinematics/kinematic_calibration.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// The text of the file of `robot` with `calibration` of the readings of `campaign` in it: values,
/// standard deviations, and as comments where they come from. `text`: of the file as it is. Throws
/// common::InputError where that is not the one that was read.
std::string calibrated_robot(const vjm::Robot& robot, const std::string& text,
                             const calibration::Campaign& campaign,
                             const calibration::KinematicCalibration& calibration);

}  // namespace kinetostat::apps
