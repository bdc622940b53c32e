// Which physical effect is missing from a model?
#pragma once

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/calibration/search/diagnosis_options.h"

namespace kinetostat::calibration {

/// Search for the missing effect, step by step: fits the uncertain parameters under every
/// candidate, screens all candidates with score tests, compares the largest score with the
/// detection threshold (a max-statistic test, which allows for the number of candidates), fits the
/// survivors with the full model, ranks them by evidence, and decides by class and place
/// (decision.h). `robot` and `campaign` as read. Throws what fit_base() throws for the nominal
/// model.
Diagnosis diagnose(const vjm::Robot& robot, const Campaign& campaign,
                   const DiagnosisOptions& options, int threads, common::Progress& progress);

}  // namespace kinetostat::calibration
