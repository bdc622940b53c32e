// One common cause that several fitted stiffnesses may stand for: an effect that alone does the
// same.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/calibration/search/candidate_fitter.h"
#include "kinetostat/calibration/statistics/goodness_of_fit.h"

namespace kinetostat::calibration {

/// An effect that is confounded with the fitted parameters, and that explains the readings to their
/// noise and as well as the fit does, by fewer values, with every uncertain parameter nominal.
struct CommonCause {
  Candidate candidate;         // with the fitted values
  Eigen::VectorXd deviations;  // NaN where a bound holds a value
  ChiSquareTest test;          // of the nominal model with it
};

/// Whether the readings reject the nominal model (F test at certain_level). `nominal` and
/// `with_all`: fits without and with the uncertain parameters.
bool refutes_nominal(const BaseFit& nominal, const BaseFit& with_all);

/// The best candidate of that kind, if any: the nominal model is rejected, and neither one
/// uncertain parameter alone nor those at the effect's own place explain the readings, so that one
/// cause behind several changes is the simpler explanation. Keeps nothing.
std::optional<CommonCause> common_cause(const vjm::Robot& robot, const Campaign& campaign,
                                        const Noise& noise, const BaseFit& with_all,
                                        const BaseFit& nominal,
                                        const std::vector<Candidate>& candidates, int threads,
                                        common::Progress& progress, FitJournal* journal);

}  // namespace kinetostat::calibration
