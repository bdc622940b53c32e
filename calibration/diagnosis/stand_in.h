// What refitting stiffnesses may hide: an effect that alone does the same.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/diagnosis/rivals.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {

/// An effect that would not show beside the refit, and that explains the readings to their noise
/// and as well as the refit, by fewer values, with everything that is uncertain as designed.
struct StandIn {
  Candidate candidate;         // with the fitted values
  Eigen::VectorXd deviations;  // NaN where a bound holds a value
  ChiSquareTest test;          // of the model as designed with it
};

/// Whether the readings refute the model with all that is uncertain as designed. `designed` and
/// `refitted`: fits without and with what is uncertain.
bool refutes_design(const BaseFit& designed, const BaseFit& refitted);

/// The best of those suspects that do so, if any: where the design is refuted, and neither one
/// uncertain parameter alone nor those at the effect's own place do it, so that one cause behind
/// several changes is the simpler explanation. Keeps nothing.
std::optional<StandIn> stand_in(const vjm::Robot& robot, const Campaign& campaign,
                                const Noise& noise, const BaseFit& refitted,
                                const BaseFit& designed, const std::vector<Candidate>& suspects,
                                int threads, common::Progress& progress, FitJournal* journal);

}  // namespace kinetostat::calibration
