// The verdict on all that a search found.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"

namespace kinetostat::calibration {

struct Judgement {
  Verdict verdict = Verdict::inconclusive;
  std::vector<std::string> missing = {};  // what readings would have to have, in sentences
};

/// A pure function of what is known. `share_left`: of the misfit, by all that was found.
Judgement judge(const Diagnosis& d, double share_left);

}  // namespace kinetostat::calibration
