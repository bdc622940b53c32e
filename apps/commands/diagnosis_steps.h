// Steps with a diagnosis that several commands share.
#pragma once

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::apps {

/// Likelihood profiles that a page shows.
inline constexpr std::size_t most_profiles = 12;

/// calibration::diagnose() with what interrupted runs left in the user's cache, unless `no_cache`.
calibration::Diagnosis resumable_diagnosis(const vjm::Robot& robot,
                                           const calibration::Campaign& campaign,
                                           calibration::DiagnosisOptions options, bool no_cache,
                                           Run& run);
void add_no_cache_option(OptionList& app, bool& no_cache);

/// The readings under the nominal model, the fitted model, and (where an effect was found) the
/// final model.
io::Json diagnosis_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const calibration::Comparison& before,
                           const calibration::Comparison* after);

}  // namespace kinetostat::apps
