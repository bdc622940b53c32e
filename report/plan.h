// Plans of measurements: for people, for `simulate`, and for programs.
#pragma once

#include <string>

#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/calibration/design/plan_score.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

std::string text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                 const calibration::PlanQuestion& question, const calibration::PlanOptions& options,
                 const calibration::Plan& plan);

/// The table of readings that `simulate` takes, in the units of the robot file, with comments on
/// the purpose of each cycle.
std::string plan_table(const vjm::Robot& robot, const calibration::Plan& plan);

io::Json to_json(const calibration::PlanQuestion& question, const calibration::PlanOptions& options,
                 const calibration::Plan& plan);

std::string text(const calibration::PlanScore& score);
io::Json to_json(const calibration::PlanScore& score);

}  // namespace kinetostat::report
