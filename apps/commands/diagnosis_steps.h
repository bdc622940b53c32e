// Steps with a diagnosis that several commands share.
#pragma once

#include <filesystem>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/calibration/comparison/compare.h"
#include "kinetostat/calibration/diagnosis/diagnosis.h"
#include "kinetostat/calibration/diagnosis/diagnosis_record.h"
#include "kinetostat/report/screen/adoption.h"
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

/// The result of `diagnose`, as `adopt` reads it.
io::Json diagnosis_result(const vjm::Robot& robot, const calibration::Campaign& campaign,
                          const calibration::DiagnosisOptions& options,
                          const calibration::Diagnosis& diagnosis);
/// The readings under the nominal model, the fitted model, and (where an effect was found) the
/// final model.
io::Json diagnosis_picture(const vjm::Robot& robot, const calibration::Campaign& campaign,
                           const calibration::Comparison& before,
                           const calibration::Comparison* after);

/// A diagnosis is of one state of one robot file: throws common::InputError when `robot` has
/// another.
void require_same_robot(const calibration::DiagnosisRecord& diagnosis,
                        const std::filesystem::path& robot);

/// What of a diagnosis goes into a robot file.
struct AdoptRequest {
  std::string robot, diagnosis, effect;  // `effect`: one of those that were found; empty: all
  bool force = false;
  bool effects_only = false;      // the stiffnesses stay as the file has them
  bool stiffnesses_only = false;  // as fitted without any effect
};
struct AdoptedFile {
  report::AdoptionSummary summary;
  io::Json result;  // as `adopt --json` has it
};
/// Writes the robot file to `out`. Throws as adopt_effect().
AdoptedFile write_adopted(const AdoptRequest& request, const std::filesystem::path& out);

/// Writes `robot` with what `diagnosis` found and fitted to `out`, and says so: all effects, or the
/// one named by `effect` ("clearance at x.rho"), then with the stiffnesses as they are. Throws
/// common::NotIdentifiable when there is none, or (unless `force`) when the held-out error does not
/// fall or the verdict is that no effect of the catalogue explains the readings.
io::Json adopt_effect(const std::filesystem::path& robot, const std::filesystem::path& diagnosis,
                      const std::string& effect, bool force, const std::filesystem::path& out,
                      Run& run);

}  // namespace kinetostat::apps
