// The error falls: held-out error of a model before and after each step of correcting it.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "kinetostat/calibration/regression/held_out.h"

namespace kinetostat::calibration {

/// Name of the stage of the model that 'adopt' writes.
inline constexpr const char* as_adopted = "as adopted";

/// Error on readings that were left out of the fit; of the stage "as adopted" on all readings, also
/// those that were set aside: what compare() says of the file as it is written.
struct WaterfallStage {
  /// As JSON has it: "as designed", "refitted", "+ clearance at x.rho", "as adopted", "noise
  /// floor".
  std::string name;
  double whitened = 0;          // rms in units of the noise; 1 is as good as the readings allow
  double translation = 0;       // rms [m]; NaN where not measured
  double rotation = 0;          // rms [rad]
  double lower = 0, upper = 0;  // 95 % of `whitened`, by bootstrap over what was left out together
  /// The same as `whitened` on readings that are kept to confirm; NaN without any.
  double confirmed = std::numeric_limits<double>::quiet_NaN();
  /// Of the stage "as adopted": the nominal model on the same readings.
  double before = std::numeric_limits<double>::quiet_NaN();
};

/// `error`: whitened held-out errors, one a value.
WaterfallStage waterfall_stage(const std::string& name, const Eigen::VectorXd& error,
                               const Campaign& campaign, const std::vector<Value>& values,
                               const Noise& noise, const HeldOutGroups& groups, std::uint64_t seed);
/// Stage of a fitted model, each of the groups left out of `values` in turn.
WaterfallStage waterfall_stage(const std::string& name, const BaseFit& fit,
                               const Campaign& campaign, const std::vector<Value>& values,
                               const Noise& noise, const HeldOutGroups& groups, std::uint64_t seed);
/// Stage of the noise alone.
WaterfallStage noise_floor(const Campaign& campaign, const std::vector<Value>& values,
                           const Noise& noise);

}  // namespace kinetostat::calibration
