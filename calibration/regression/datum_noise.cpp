#include "kinetostat/calibration/regression/datum_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/QR>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/noise_estimate.h"
#include "kinetostat/calibration/regression/undetermined.h"
#include "kinetostat/calibration/regression/wrench_noise.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int most_halvings = 6;
const double in_doubt = std::log(10.0);  // of the log likelihood
constexpr double most_misfit = 1.5;      // times the noise, of a model by which datums are judged

bool is_open(const Campaign& campaign, const Noise& noise) {
  return campaign.displacement == DisplacementKind::difference && !noise.datums.empty() &&
         campaign.datum_noise.array().isNaN().any() &&
         campaign.readings.size() <= most_for_datums && !campaign.control;
}

// Datums with `factor` times their usual variance; stated ones as they are.
Noise with_datums(Noise noise, const Campaign& campaign, double factor) {
  for (Datum& datum : noise.datums)
    for (Index k = 0; k < datum.sigma.size(); ++k)
      if (std::isnan(campaign.datum_noise[k])) datum.sigma[k] *= std::sqrt(factor);
  return noise;
}

struct Reference {
  Noise noise;  // with that of the wrenches
  BaseFit fit;
};

std::optional<Reference> fit_without_effects(const Noise& noise, const vjm::Robot& robot,
                                             const Campaign& campaign, int threads,
                                             common::Progress& progress) {
  std::vector<Parameter> parameters = uncertain_parameters(robot);
  std::erase_if(parameters, [](const Parameter& p) { return p.springs.empty(); });
  for (Parameter& parameter : parameters) parameter.prior.reset();
  Reference result;
  const std::optional<BaseFit> fit = if_possible([&]() -> std::optional<BaseFit> {
    const Predictor predictor(robot.without_effects(), {}, campaign, threads, progress);
    keep_undetermined(predictor, campaign, noise, parameters, progress);
    result.noise =
        with_wrench_noise(noise, campaign, predictor, parameters, starts_of(parameters), progress);
    return fit_base(predictor, campaign, result.noise, parameters, progress,
                    {.accept_unsettled = true});
  });
  if (!fit) return std::nullopt;
  result.fit = *fit;
  return result;
}

// Whether a model nearly explains the readings. A noise by replicates is as much too small as
// datums are taken to be noisier than they are.
bool is_near(const Reference& reference) {
  const BaseFit& fit = reference.fit;
  const auto freedom = static_cast<double>(std::max<Index>(1, fit.degrees_of_freedom()));
  const double too_small =
      reference.noise.source == NoiseSource::replicates ? std::sqrt(1 + usual_datum_variance) : 1;
  return std::sqrt(fit.squared_error / freedom) <= too_small * most_misfit;
}

// Columns of readings: of one session and component each.
MatrixXd drifts(const Campaign& campaign, const std::vector<Value>& values) {
  std::map<std::pair<std::size_t, Index>, Index> column;
  for (const Value& v : values)
    column.emplace(std::pair(campaign.readings[v.reading].session, v.component),
                   2 * std::ssize(column));
  MatrixXd result = MatrixXd::Zero(std::ssize(values), 2 * std::ssize(column));
  for (Index row = 0; row < result.rows(); ++row) {
    const Value& v = values[static_cast<std::size_t>(row)];
    const Reading& reading = campaign.readings[v.reading];
    const Index first = column.at({reading.session, v.component});
    result(row, first) = reading.time.value_or(0);
    result(row, first + 1) = reading.temperature.value_or(0);
  }
  return result;
}

// The residual, then all that is fitted, in columns of unit length.
MatrixXd residual_and_fitted(const Reference& reference, const Campaign& campaign,
                             const std::vector<Value>& values) {
  const Linearisation& at = reference.fit.at;
  MatrixXd known(at.residual.size(), 1 + at.jacobian.cols()), trends = drifts(campaign, values);
  known << at.residual, at.jacobian;
  SharedNoise(reference.noise, values).restore(known);
  whiten_singly(reference.noise, values, trends);
  MatrixXd all(known.rows(), known.cols() + trends.cols());
  all << known, trends;
  for (Index c = 1; c < all.cols(); ++c) all.col(c).stableNormalize();
  return all;
}

// Restricted log likelihood of readings, whatever the scale of their noise.
double log_likelihood(const Noise& noise, const std::vector<Value>& values, MatrixXd columns) {
  const SharedNoise shared(noise, values);
  shared.whiten(columns);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(columns.rightCols(columns.cols() - 1));
  qr.setThreshold(1e-9);
  const Index rank = qr.rank();
  const VectorXd left =
      (qr.householderQ().transpose() * columns.col(0)).tail(columns.rows() - rank);
  return -0.5 * shared.log_determinant() -
         qr.matrixQR().diagonal().head(rank).cwiseAbs().array().log().sum() -
         static_cast<double>(left.size()) * std::log(left.norm());
}

}  // namespace

Noise with_datums_seen(Noise noise, const vjm::Robot& robot, const Campaign& campaign, int threads,
                       common::Progress& progress) {
  if (!is_open(campaign, noise)) return noise;
  const auto reference = fit_without_effects(noise, robot, campaign, threads, progress);
  if (!reference || !is_near(*reference)) return noise;
  const std::vector<Value> values = values_in_use(campaign);
  const MatrixXd columns = residual_and_fitted(*reference, campaign, values);
  std::vector<double> logs;
  for (int k = 0; k <= most_halvings; ++k)
    logs.push_back(log_likelihood(with_datums(reference->noise, campaign, std::ldexp(1.0, -k)),
                                  values, columns));
  const double most = *std::max_element(logs.begin(), logs.end());
  const auto first =
      std::find_if(logs.begin(), logs.end(), [&](double log) { return log >= most - in_doubt; });
  const double factor = std::ldexp(1.0, -static_cast<int>(first - logs.begin()));
  return with_scatter(with_datums(std::move(noise), campaign, factor), campaign,
                      replicate_groups(campaign));
}

}  // namespace kinetostat::calibration
