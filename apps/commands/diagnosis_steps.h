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

/// Where a diagnosis keeps its fits: in the user's cache, unless this says something else.
struct KeptFits {
  bool nowhere = false;
  std::string shared;  // folder of all workers on the same diagnosis; empty: there is one worker
};

/// calibration::diagnose() with what interrupted runs and other workers have kept. Throws
/// common::InputError where the shared folder cannot be written to.
calibration::Diagnosis resumable_diagnosis(const vjm::Robot& robot,
                                           const calibration::Campaign& campaign,
                                           calibration::DiagnosisOptions options,
                                           const KeptFits& kept, Run& run);
void add_options(OptionList& app, KeptFits& kept);

/// The readings under the nominal model, the fitted model, and (where an effect was found) the
/// final model.
io::Json diagnosis_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const calibration::Comparison& before,
                           const calibration::Comparison* after);

}  // namespace kinetostat::apps
