// What of a diagnosis goes into a robot file.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/calibration/diagnosis/diagnosis_record.h"
#include "kinetostat/io/json.h"
#include "kinetostat/report/screen/adoption.h"
#include "kinetostat/vjm/io/link_options.h"

namespace kinetostat::apps {

/// A diagnosis is of one state of one robot file: throws common::InputError when `robot` has
/// another.
void require_same_robot(const calibration::DiagnosisRecord& diagnosis,
                        const std::filesystem::path& robot);

struct AdoptRequest {
  std::string robot, diagnosis, effect;  // `effect`: one of those that were found; empty: all
  bool force = false;
  bool effects_only = false;      // the stiffnesses stay as the file has them
  bool stiffnesses_only = false;  // as fitted without any effect
  vjm::LinkOptions reading = {};  // of the robot file
};

struct Adopted {     // NOLINT(bugprone-exception-escape): moving a Json throws nothing
  std::string text;  // of the robot file
  report::AdoptionSummary summary;
  io::Json result;  // as `adopt --json` has it
};

/// The robot file with what the diagnosis found and fitted: all effects, or the one named by
/// `effect` ("clearance at x.rho"), then with the stiffnesses as they are. `out`: where it will be.
/// Throws common::NotIdentifiable when there is none, or (unless `force`) when the held-out error
/// does not fall or the verdict is that no effect of the catalogue explains the readings.
Adopted adopt(const calibration::DiagnosisRecord& diagnosis, const AdoptRequest& request,
              const std::filesystem::path& out);
/// The same from the file of a diagnosis, written to `out`.
Adopted write_adopted(const AdoptRequest& request, const std::filesystem::path& out);

}  // namespace kinetostat::apps
