#include "kinetostat/calibration/regression/correlation.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

EstimateCorrelation EstimateCorrelation::only(const std::vector<std::string>& some) const {
  std::vector<Eigen::Index> kept;
  EstimateCorrelation part;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(some.begin(), some.end(), names[i]) == some.end()) continue;
    kept.push_back(static_cast<Eigen::Index>(i));
    part.names.push_back(names[i]);
  }
  part.matrix = matrix(kept, kept);
  return part;
}

EstimateCorrelation correlation_of(const BaseFit& fit) {
  EstimateCorrelation result;
  std::vector<Eigen::Index> known;
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    const ParameterEstimate& estimate = fit.parameters[i];
    const auto at = static_cast<Eigen::Index>(i);
    if (estimate.hit != BoundHit::none || !(fit.covariance(at, at) > 0)) continue;
    known.push_back(at);
    result.names.push_back(estimate.parameter.is_logarithm()
                               ? vjm::fitted_source(estimate.parameter.name)
                               : estimate.parameter.name);
  }
  const Eigen::MatrixXd covariance = fit.covariance(known, known);
  const Eigen::VectorXd inverse = covariance.diagonal().cwiseSqrt().cwiseInverse();
  result.matrix = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  result.matrix.diagonal().setOnes();
  return result;
}

}  // namespace kinetostat::calibration
