#include "kinetostat/calibration/regression/undetermined.h"

#include <algorithm>

#include <fmt/format.h>

#include "kinetostat/calibration/regression/base_fit.h"
#include "kinetostat/calibration/statistics/identifiability.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double unseen = 0.3;  // d' of a change that is worth knowing: a factor of e

// Derivatives of the values in use in units of their noise, one column a parameter, for a change
// that is worth knowing.
MatrixXd signatures_of(const Predictions& predictions, const std::vector<Value>& values,
                       const Noise& noise, const std::vector<Parameter>& parameters) {
  MatrixXd signatures(static_cast<Index>(values.size()), static_cast<Index>(parameters.size()));
  for (Index v = 0; v < signatures.rows(); ++v) {
    const auto& [reading, component] = values[static_cast<std::size_t>(v)];
    signatures.row(v) =
        predictions.derivatives[reading].row(component) / noise.sigma[reading][component];
  }
  for (Index k = 0; k < signatures.cols(); ++k)
    signatures.col(k) *= parameters[static_cast<std::size_t>(k)].typical;
  return signatures;
}

}  // namespace

std::vector<std::string> keep_undetermined(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise, std::vector<Parameter>& parameters,
                                           common::Progress& progress) {
  std::vector<std::string> kept;
  if (parameters.empty()) return kept;
  const Predictions there = predictor.predict(parameters, starts_of(parameters), true, progress);
  if (there.failure) return kept;
  const std::vector<Value> values = values_in_use(campaign);
  const MatrixXd signatures = signatures_of(there, values, noise, parameters);
  const double visible =
      std::max(unseen, sensitivity_rounding * norm_over_noise(values, campaign, noise));
  for (const Index k :
       made_up_by_those_before(signatures, VectorXd::Constant(signatures.cols(), visible))) {
    Parameter& parameter = parameters[static_cast<std::size_t>(k)];
    parameter.lower = parameter.upper = parameter.start;
    parameter.bounds_stated = true;
    kept.push_back(fmt::format("{} stays at its nominal value: {}.", parameter.phrase(),
                               signatures.col(k).norm() > visible
                                   ? "it is confounded with the fitted parameters"
                                   : "no reading depends on it"));
  }
  return kept;
}

}  // namespace kinetostat::calibration
