// First screens of `compare` and `measure check`, and what other commands say of a comparison.
#pragma once

#include <string>

#include "kinetostat/calibration/campaign/campaign_check.h"
#include "kinetostat/calibration/campaign/joint_loads.h"
#include "kinetostat/calibration/comparison/before_after.h"
#include "kinetostat/calibration/comparison/compare.h"

namespace kinetostat::report {

/// How the model and its readings agree, in one sentence with both errors.
std::string headline(const calibration::Comparison& comparison);
/// Headline, at most four things that the error of the best model depends on with their shares,
/// errors by component, what was fitted. `next`: the last line.
std::string first_screen(const vjm::Robot& robot, const calibration::Campaign& campaign,
                         const calibration::Comparison& comparison, const std::string& next);
/// "q1 +16 % +- 7, q3 +18 % +- 4; within their error: q2"; empty where nothing was fitted.
std::string fitted_in_words(const vjm::Robot& robot, const calibration::BaseFit& fit);
/// Only what changed: "q1 +16 % +- 7 and q3 +18 % +- 4, not distinguished from q2".
std::string changed_in_words(const vjm::Robot& robot, const calibration::BaseFit& fit);

/// How the held-out error of two models compares.
std::string headline(const calibration::BeforeAfter& both);
std::string first_screen(const calibration::BeforeAfter& both);

/// "192 of 192 readings usable, 2 sessions, 13 postures, noise stated".
std::string readings_in_words(const calibration::Campaign& campaign,
                              const std::vector<calibration::Observability>& checks);
/// Every joint with a spring, and what the loads do to it. Empty where there is none.
std::string joints_text(const std::vector<calibration::JointLoad>& joints);
/// What readings can show and what not, with what would show it, and the joints whose stiffness
/// cannot be determined.
std::string first_screen(const calibration::Campaign& campaign,
                         const std::vector<calibration::Observability>& checks,
                         const std::vector<calibration::JointLoad>& joints,
                         const std::string& next);

}  // namespace kinetostat::report
