// The physical picture of an effect: load at its joint against its deflection, and the robot bent.
#pragma once

#include "kinetostat/calibration/comparison/joint_curve.h"
#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// The curve at the first effect that was found at a joint with a spring of its own, in columns,
/// SI, one entry a reading; null where there is none. `before`, `after`: the readings compared with
/// the robot, and with the robot that has all that was found.
io::Json joint_curve_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                             const calibration::Diagnosis& diagnosis,
                             const calibration::Comparison& before,
                             const calibration::Comparison& after, int threads,
                             common::Progress& progress);

/// The robot in the posture of the largest force of the campaign, unloaded and under it, with that
/// load and the place of the first effect that was found; null where there is no equilibrium.
io::Json bent_robot_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                            const calibration::Diagnosis& diagnosis);

}  // namespace kinetostat::report
