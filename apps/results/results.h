// Results of commands on readings, as their JSON has them.
#pragma once

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/calibration/kinematics/kinematic_calibration.h"
#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// That of `diagnose`, as `adopt` reads it.
io::Json diagnosis_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                          const calibration::DiagnosisOptions& options,
                          const calibration::Diagnosis& diagnosis);
/// That of `compare`: every reading.
io::Json comparison_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const calibration::Comparison& comparison);
/// That of `calibrate`, but for the file that it writes.
io::Json calibration_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                            const calibration::KinematicCalibration& calibration);
/// That of `plan`.
io::Json plan_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     const calibration::PlanQuestion& question,
                     const calibration::PlanOptions& options, const calibration::Plan& plan);

}  // namespace kinetostat::apps
