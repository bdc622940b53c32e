// The verdict on what a model lacks, for people and for programs.
#pragma once

#include <string>

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"
#include "kinetostat/io/json.h"

namespace kinetostat::report {

/// A verdict (calibration::to_string) for people: JSON's "these data cannot tell" is
/// "inconclusive".
std::string verdict_in_words(const std::string& verdict);
std::string text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                 const calibration::Diagnosis& diagnosis);
/// Every figure, SI.
io::Json to_json(const vjm::Robot& robot, const calibration::Campaign& campaign,
                 const calibration::Diagnosis& diagnosis);

}  // namespace kinetostat::report
