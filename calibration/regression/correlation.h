// How estimates depend on each other, by the names that a robot file has for them.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::calibration {

struct BaseFit;

/// Correlations of numbers with the names of their sources of uncertainty in a robot file
/// (vjm::UncertaintySource): "fitted stiffness of q1", "gap of clearance at q3".
struct EstimateCorrelation {
  std::vector<std::string> names;
  Eigen::MatrixXd matrix;  // square, ones on the diagonal

  /// The part with some of the names.
  EstimateCorrelation only(const std::vector<std::string>& some) const;
};

/// Of the parameters of a fit, without those that have no standard error.
EstimateCorrelation correlation_of(const BaseFit& fit);

}  // namespace kinetostat::calibration
