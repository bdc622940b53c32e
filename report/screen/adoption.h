// First screen of `adopt` and `revert`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/adoption.h"
#include "kinetostat/calibration/diagnosis/diagnosis_record.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::report {

/// What went into a robot file. Errors in units of the noise; NaN where they are not known.
struct AdoptionSummary {
  std::filesystem::path file;
  std::vector<std::string> effects;  // in words
  std::vector<calibration::AdoptedParameter> fitted;
  double nominal = calibration::not_recorded;  // error of the file as it was
  double before = calibration::not_recorded, after = calibration::not_recorded;  // held out
  double as_written = calibration::not_recorded;                                 // on all readings
  std::vector<std::string> reservations;  // what to know before the file is used
};

/// "calibrated.yaml: friction at joint q2, and 6 fitted values (q1 +16 % +- 7 ...)."
std::string headline(const vjm::Robot& robot, const AdoptionSummary& adoption);
/// Headline, the error of the file as it is written, reservations.
std::string first_screen(const vjm::Robot& robot, const AdoptionSummary& adoption,
                         const std::string& next);

}  // namespace kinetostat::report
