// What a diagnosis looks at first, as plain columns: for methods other than ours.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// All in units of the noise, about the fit without any effect: a row for each value of a reading.
struct SignatureTable {
  std::vector<Value> values;
  Eigen::VectorXd residual;  // measured minus predicted
  /// By what is fitted anyway: declared parameters, then frames of sessions and the like.
  std::vector<std::string> fitted;
  Eigen::MatrixXd by_fitted;
  /// Of each candidate that the readings show: the change of the predictions by its usual size, and
  /// by one prior standard deviation of each further value.
  std::vector<std::string> candidates;  // "clearance at q2", once for each of its columns
  Eigen::MatrixXd by_candidates;
};

}  // namespace kinetostat::calibration
