// How well a fitted model predicts readings that it was not fitted to.
#pragma once

#include <vector>

#include "kinetostat/calibration/regression/base_fit.h"

namespace kinetostat::calibration {

/// Values in use that are left out together, because errors of the model are alike in them:
/// configurations; where there are fewer than four, load cycles; else distinct loads; else single
/// readings.
struct HeldOutGroups {
  std::vector<std::vector<Eigen::Index>> members;  // indices of values
  std::string what;                                // "configurations"
};
HeldOutGroups held_out_groups(const Campaign& campaign, const std::vector<Value>& values);

struct HeldOut {
  /// Logarithm of the predictive density of each group, given all the others.
  std::vector<double> log_score;
  Eigen::VectorXd error;  // measured minus predicted, whitened, each value left out with its group

  double total() const;
};

/// Gives each value that a bound holds a precision so large that it does not move when readings are
/// left out.
void hold_bounds(const BaseFit& fit, Eigen::VectorXd& information);
/// Precision of each unknown of a fit without any reading: that of its prior, else that of its
/// range, within which it stays when the readings that determine it are left out; 0 for an unknown
/// without either.
Eigen::VectorXd prior_information(const BaseFit& fit);

/// Leaves every group out in turn, by the linear model about the fit: exact for a linear model, one
/// Gauss-Newton step otherwise. `information`: prior precision of each unknown of the fit (0:
/// none); an unknown that neither a prior nor any reading determines changes nothing. `exponent`:
/// power-posterior exponent, the weight of the readings (1, or less where the noise is larger than
/// stated).
HeldOut held_out(const Linearisation& fit, const Eigen::VectorXd& information,
                 const HeldOutGroups& groups, double exponent);

}  // namespace kinetostat::calibration
