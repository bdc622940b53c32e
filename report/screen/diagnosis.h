// First screen of `diagnose`, and its verdict in one sentence.
#pragma once

#include <string>

#include "kinetostat/calibration/diagnosis/diagnosis_result.h"

namespace kinetostat::report {

/// The verdict with what it rests on: "Friction at joint q2: 0.57 +- 0.04 N m (over 99.9 %)."
std::string headline(const vjm::Robot& robot, const calibration::Campaign& campaign,
                     const calibration::Diagnosis& diagnosis);
/// The same in a few words: "friction at joint q2, over 99.9 %".
std::string verdict_in_short(const vjm::Robot& robot, const calibration::Diagnosis& diagnosis);

/// Candidates that were weighed and are not it, the most probable first, with their odds against
/// the rest: "creep at joint q2 (1 : 1,200,000)". At most `most`.
std::vector<std::pair<std::string, double>> excluded(const vjm::Robot& robot,
                                                     const calibration::Diagnosis& diagnosis,
                                                     std::size_t most);
/// Kinds of effects that are not observable in these readings at their usual sizes, in words.
std::vector<std::string> not_observable(const calibration::Diagnosis& diagnosis);

/// Headline, the falling error, what is not it, what is not observable. `next`: the last lines.
std::string first_screen(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const calibration::Diagnosis& diagnosis, const std::string& next);

}  // namespace kinetostat::report
