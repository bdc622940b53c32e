// The verdict on what a model lacks, for people.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"

namespace kinetostat::report {

/// A verdict (calibration::to_string) for people: JSON's "these data cannot tell" is
/// "inconclusive".
std::string verdict_in_words(const std::string& verdict);
std::string text(const vjm::Robot& robot, const calibration::Campaign& campaign,
                 const calibration::Diagnosis& diagnosis);
/// Unit of a value of an effect: simple ones as the campaign has them, compound ones in SI,
/// compliances in millionths ("um/N", "urad/(N m)").
std::string unit_for_people(const calibration::Campaign& campaign,
                            const vjm::EffectParameter& parameter, bool angular);
/// The answers of a decision in one sentence: class and places, with their probability.
std::string answers_text(const calibration::Decision& decision);
/// The laws of the first answer with their shares; empty where there is only one.
std::string laws_text(const calibration::Decision& decision);
/// Why more readings would be no use; empty where they would.
std::string inseparable_text(const calibration::Decision& decision);
/// What a reader of the verdict should know beside it, in sentences.
std::vector<std::string> remarks(const vjm::Robot& robot, const calibration::Campaign& campaign,
                                 const calibration::Diagnosis& diagnosis);

}  // namespace kinetostat::report
