// What a kinematic calibration writes: a robot file with the geometry that was found.
#pragma once

#include <string>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/kinematics/kinematic_calibration.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// The text of the file of `robot` with `calibration` of the readings of `campaign` in it: values,
/// standard deviations, and as comments where they come from. Throws common::InputError where the
/// file is not the one that was read.
std::string calibrated_robot(const vjm::Robot& robot, const calibration::Campaign& campaign,
                             const calibration::KinematicCalibration& calibration);

}  // namespace kinetostat::apps
