// The file of a diagnosis: what `diagnose -o` writes and `adopt`, `plan` and pages read.
#pragma once

#include <filesystem>

#include "kinetostat/calibration/diagnosis/diagnosis_record.h"
#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// Every figure, SI.
io::Json to_json(const vjm::Robot& robot, const calibration::Campaign& campaign,
                 const calibration::Diagnosis& diagnosis);

/// What was written by to_json(), with or without `inputs` and `readings` beside it. `file` is for
/// messages. Throws common::InputError when it is no diagnosis.
calibration::DiagnosisRecord diagnosis_record(const io::Json& json,
                                              const std::filesystem::path& file);
/// Reads a file. Throws common::InputError when it is no diagnosis.
calibration::DiagnosisRecord read_diagnosis(const std::filesystem::path& file);

}  // namespace kinetostat::report
