// First screen of `plan`, and what it promises in one sentence.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

std::string headline(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                     const calibration::PlanOptions& options, const calibration::Plan& plan);
/// The same in a few words: "6 readings, 12 min: distinguish ...".
std::string plan_in_short(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                          const calibration::Plan& plan);

/// Cycles of a plan that are one line of a work list: of one posture, or of one joint that is moved
/// alone; repeated ones counted.
struct WorkStep {
  std::string posture, load, how;
  std::size_t cycles = 0, readings = 0;
  double minutes = 0;
  std::string why;
};
std::vector<WorkStep> work_list(const vjm::Robot& robot, const calibration::Plan& plan);
io::Json to_json(const std::vector<WorkStep>& steps);

/// Headline and the work list. `next`: the last lines.
std::string first_screen(const vjm::Robot& robot, const calibration::PlanQuestion& question,
                         const calibration::PlanOptions& options, const calibration::Plan& plan,
                         const std::string& next);

}  // namespace kinetostat::report
