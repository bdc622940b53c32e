// Two models against the same readings: did the error fall?
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/comparison/waterfall.h"

namespace kinetostat::calibration {

struct BeforeAfter {
  Comparison before, after;
  /// Names as JSON has them: `before, as designed`, `before, refitted`, `after, ...`, the
  /// noise floor, as far as there are parameters to fit. Empty where the noise is not known.
  std::vector<WaterfallStage> stages;
  std::string held_out;  // what was left out together: "configurations"
};

/// Each robot is compared as by itself. `campaign` must fit both. Throws what compare() throws.
BeforeAfter compare_before_after(const vjm::Robot& before, const vjm::Robot& after,
                                 const Campaign& campaign, int threads, common::Progress& progress,
                                 Loss loss = Loss::squares);

}  // namespace kinetostat::calibration
