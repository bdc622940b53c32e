// Plans of measurements: for people, for `simulate`, and for programs.
#pragma once

#include <filesystem>
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
/// What a plan that to_json() wrote promised. `file` is for messages. Throws common::InputError
/// when it is no plan.
calibration::PlanPromise promise_of(const io::Json& plan, const std::filesystem::path& file);

std::string text(const calibration::PlanScore& score);
io::Json to_json(const calibration::PlanScore& score);

}  // namespace kinetostat::report
