#include "kinetostat/calibration/regression/undetermined.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "kinetostat/calibration/statistics/identifiability.h"
#include "kinetostat/calibration/statistics/least_squares.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double deviation_of_design = 1;  // of the logarithm of a stiffness: a factor of e
constexpr double unseen = 0.3;             // d' of a change that is worth knowing: a factor of e

// Derivatives of the values in use in units of their noise, one column a parameter, for a change
// that is worth knowing. Nothing where the model fails.
std::optional<MatrixXd> signatures_of(const Predictor& predictor, const std::vector<Value>& values,
                                      const Noise& noise, const std::vector<Parameter>& parameters,
                                      common::Progress& progress) {
  const std::vector<std::size_t> first = first_values(values, noise.sigma.size());
  MatrixXd signatures(static_cast<Index>(values.size()), static_cast<Index>(parameters.size()));
  const auto take = [&](std::size_t reading, VectorXd&, spatial::Vector6&,
                        const MatrixXd& derivatives) {
    for (std::size_t v = first[reading]; v < values.size() && values[v].reading == reading; ++v)
      signatures.row(static_cast<Index>(v)) =
          derivatives.row(values[v].component) / noise.sigma[reading][values[v].component];
  };
  if (predictor
          .predict(parameters, starts_of(parameters), parameters, progress,
                   {.take = take, .few_states = true})
          .failure)
    return std::nullopt;
  for (Index k = 0; k < signatures.cols(); ++k)
    signatures.col(k) *= parameters[static_cast<std::size_t>(k)].typical;
  return condensed(signatures);
}

}  // namespace

std::vector<std::string> keep_undetermined(const Predictor& predictor, const Campaign& campaign,
                                           const Noise& noise, std::vector<Parameter>& parameters,
                                           common::Progress& progress) {
  std::vector<std::string> kept;
  if (parameters.empty()) return kept;
  const std::vector<Value> values = values_in_use(campaign);
  const std::optional<MatrixXd> signatures =
      signatures_of(predictor, values, noise, parameters, progress);
  if (!signatures) return kept;
  const double rounding = sensitivity_rounding * norm_over_noise(values, campaign, noise);
  const double visible =
      noise.source == NoiseSource::unknown ? rounding : std::max(unseen, rounding);
  for (const Index k :
       made_up_by_those_before(*signatures, VectorXd::Constant(signatures->cols(), visible))) {
    Parameter& parameter = parameters[static_cast<std::size_t>(k)];
    parameter.lower = parameter.upper = parameter.start;
    parameter.bounds_stated = true;
    parameter.is_confounded = signatures->col(k).norm() > visible;
    kept.push_back(fmt::format("{} stays at its nominal value: {}.", parameter.phrase(),
                               parameter.is_confounded
                                   ? "it is confounded with the fitted parameters"
                                   : "no reading depends on it"));
  }
  return kept;
}

bool believe_design(std::vector<Parameter>& parameters) {
  constexpr double farthest = 3;  // standard deviations
  bool any = false;
  for (Parameter& p : parameters) {
    if (!p.is_logarithm() || p.is_held() || p.prior) continue;
    p.prior = Parameter::Prior{.mean = p.start, .deviation = deviation_of_design};
    any = true;
    if (p.bounds_stated) continue;
    p.lower = p.start - farthest * deviation_of_design;
    p.upper = p.start + farthest * deviation_of_design;
    p.bounds_stated = true;
  }
  return any;
}

bool is_held_near_design(const BaseFit& fit) {
  return std::any_of(fit.parameters.begin(), fit.parameters.end(), [](const auto& estimate) {
    return estimate.parameter.is_logarithm() && estimate.parameter.prior;
  });
}

std::vector<std::string> cautions_about(const BaseFit& fit) {
  std::vector<std::string> cautions;
  if (is_held_near_design(fit))
    cautions.emplace_back(
        "The readings alone leave some stiffness open, or drive it to a bound or far from its "
        "design: all that are uncertain are fitted as known by design to a factor of 2.7, one "
        "standard deviation.");
  if (!fit.is_settled)
    cautions.push_back(fmt::format(
        "The fit still moves after {} evaluations of the model: its values are the best so far, "
        "and uncertain by more than their standard deviations.",
        fit.iterations));
  return cautions;
}

namespace {

// Units of loads whose ratio a stiffness may come out by.
std::string units_of_loads(double factor) {
  constexpr double alike = 1.12;
  constexpr std::pair<double, const char*> known[] = {
      {2.20462, ", as of weights in lb taken for kg"},
      {1 / 2.20462, ", as of weights in kg taken for lb"},
      {4.44822, ", as of forces in N taken for lbf"},
      {1 / 4.44822, ", as of forces in lbf taken for N"},
  };
  for (const auto& [ratio, words] : known)
    if (std::abs(std::log(factor / ratio)) < std::log(alike)) return words;
  return {};
}

}  // namespace

std::string common_factor(const std::vector<ParameterEstimate>& parameters) {
  constexpr double off = 1.7, alike = 1.15, known = 0.1;  // either way; standard error
  double sum = 0, least = std::numeric_limits<double>::infinity(), most = -least;
  std::size_t count = 0;
  for (const auto& [parameter, value, error, hit] : parameters) {
    if (!parameter.is_logarithm() || hit != BoundHit::none || !(error < known)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
    sum += value;
    ++count;
  }
  const double mean = sum / static_cast<double>(count);
  if (count < 2 || std::abs(mean) < std::log(off) || most - least > 2 * std::log(alike)) return {};
  return fmt::format(
      "All {} stiffnesses that these readings know are about {:.2g} times those of the robot file: "
      "see whether loads and displacements are in the units that are stated{}.",
      count, std::exp(mean), units_of_loads(std::exp(mean)));
}

bool strays_from_design(const BaseFit& fit) {
  return std::any_of(fit.parameters.begin(), fit.parameters.end(), [](const auto& estimate) {
    const Parameter& p = estimate.parameter;
    if (!p.is_logarithm() || p.is_held() || p.prior) return false;
    if (p.bounds_stated) return estimate.hit != BoundHit::none;
    return estimate.hit == BoundHit::none && std::abs(estimate.value) > std::log(doubtful_factor) &&
           estimate.standard_error > deviation_of_design;
  });
}

}  // namespace kinetostat::calibration
