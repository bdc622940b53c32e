#include "kinetostat/calibration/regression/wrench_noise.h"

#include <cmath>

#include "kinetostat/calibration/regression/session_frame.h"

namespace kinetostat::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

MatrixXd covariance_of(const Noise& noise, std::size_t reading) {
  const VectorXd& sigma = noise.sigma[reading];
  if (noise.correlation.empty() || !noise.correlation[reading])
    return sigma.cwiseAbs2().asDiagonal();
  return sigma.asDiagonal() * *noise.correlation[reading] * sigma.asDiagonal();
}

void set_covariance(const MatrixXd& covariance, std::size_t reading, Noise& noise) {
  VectorXd& sigma = noise.sigma[reading];
  MatrixXd correlation = MatrixXd::Identity(sigma.size(), sigma.size());
  // What is not measured has no noise of its own, and nothing to be correlated with.
  for (Eigen::Index i = 0; i < sigma.size(); ++i)
    if (covariance(i, i) > 0) sigma[i] = std::sqrt(covariance(i, i));
  for (Eigen::Index i = 0; i < sigma.size(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (covariance(i, i) > 0 && covariance(j, j) > 0)
        correlation(i, j) = correlation(j, i) = covariance(i, j) / (sigma[i] * sigma[j]);
  noise.correlation[reading] = std::make_shared<const MatrixXd>(correlation);
}

// Turns what is read in the frame of a session, as seen_from() has it.
void turn_into(const Vector6& frame, const Campaign& campaign, const Reading& reading,
               const VectorXd& predicted, MatrixXd& compliance) {
  for (const auto& [axes, rows] : framed_components(campaign)) {
    Vector6 displacement = Vector6::Zero(), measured = Vector6::Zero();
    displacement(axes) = predicted(rows);
    measured(axes) = reading.displacement(rows);
    spatial::Matrix6 before = spatial::Matrix6::Zero();
    before(axes, Eigen::all) = compliance(rows, Eigen::all);
    const spatial::Matrix6 after =
        seen_from(frame, displacement, campaign.displacement, measured).by_displacement * before;
    compliance(rows, Eigen::all) = after(axes, Eigen::all);
  }
}

}  // namespace

Noise with_wrench_noise(const Noise& noise, const Campaign& campaign, const Predictor& predictor,
                        const std::vector<Parameter>& parameters, const VectorXd& values,
                        common::Progress& progress, const BaseFit* found) {
  if (campaign.wrench_covariance.empty()) return noise;
  Predictions predictions = predictor.predict_with_compliance(
      parameters, values, progress,
      found != nullptr ? targets_of(*found) : std::vector<TargetOffset>());
  Noise result = noise;
  result.correlation.resize(campaign.readings.size());
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& reading = campaign.readings[i];
    MatrixXd& c = predictions.by_wrench[i];
    if (found != nullptr)
      if (const auto frame = known_frame(*found, reading.session))
        turn_into(*frame, campaign, reading, predictions.displacement[i], c);
    const MatrixXd added = c * campaign.wrench_covariance[i] * c.transpose();
    if (added.allFinite()) set_covariance(covariance_of(noise, i) + added, i, result);
  }
  return result;
}

}  // namespace kinetostat::calibration
