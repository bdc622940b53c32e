// Score of a plan: the promised separation, and that of its readings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/design/plan.h"
#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

struct Diagnosis;  // diagnosis_result.h

/// What a plan promised, as its file says it.
struct PlanPromise {
  std::vector<PlannedSplit> splits;
  std::vector<PlannedSharpening> sharpened;
};

/// Two models that were to be distinguished.
struct SplitScore {
  std::string a, b;
  double expected = 0;             // gain of log evidence of the one over the other [nats]
  std::optional<double> realised;  // none where one of them has no fit any more, or had none
  std::string why_not;             // then
};

/// A number that was to be known better.
struct SharpeningScore {
  std::string name;
  double before = 0, expected = 0;  // standard deviations
  std::optional<double> realised;
};

struct PlanScore {
  std::vector<SplitScore> splits;
  std::vector<SharpeningScore> sharpened;
};

/// Score of what a plan promised, by a diagnosis of the readings so far with those of the plan.
PlanScore score_plan(const PlanPromise& promise, const vjm::Robot& robot, const Campaign& campaign,
                     const Diagnosis& diagnosis, int threads, common::Progress& progress);

}  // namespace kinetostat::calibration
