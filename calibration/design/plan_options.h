// What a batch of readings may cost, and what it is for.
#pragma once

#include <vector>

#include "kinetostat/calibration/design/plan_blocks.h"

namespace kinetostat::calibration {

struct PlanOptions {
  MeasuringOptions measuring = {};
  double minutes = 120;  // that the batch may take
  double wanted = 5;     // d' from which two models count as distinguished
  std::vector<spatial::Pose> work_at =
      {};  // where the model is used; none: at the campaign's postures
};

}  // namespace kinetostat::calibration
