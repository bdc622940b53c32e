#include "kinetostat/calibration/search/correlated_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include <Eigen/QR>
#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/regression/evidence.h"
#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double out_of_question = 6.9;  // of log evidence: a thousand to one

}  // namespace

CorrelatedNoise::CorrelatedNoise(const Campaign& campaign, const std::vector<Value>& values,
                                 const Noise& noise) {
  if (campaign.displacement == DisplacementKind::difference) add_zeros(campaign, values, noise);
  add_fading(campaign, values);
}

void CorrelatedNoise::add_zeros(const Campaign& campaign, const std::vector<Value>& values,
                                const Noise& noise) {
  std::map<std::tuple<std::size_t, std::string, std::size_t, Index>, Rows> shared;
  bool in_cycles = false;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const Reading& reading = campaign.readings[values[v].reading];
    in_cycles |= !reading.cycle.empty();
    const std::size_t configuration = reading.cycle.empty() ? reading.configuration : 0;
    shared[{reading.session, reading.cycle, configuration, values[v].component}].push_back(
        static_cast<Index>(v));
  }
  if (std::all_of(shared.begin(), shared.end(), [](const auto& s) { return s.second.size() < 2; }))
    return;
  const auto sigma = [&](Index row) {
    const Value& value = values[static_cast<std::size_t>(row)];
    return noise.sigma[value.reading][value.component];
  };
  Way way{.what = fmt::format("readings of one {} are off together, as the noise of the one "
                              "reading without load that they are counted from makes them",
                              in_cycles ? "cycle" : "configuration")};
  const SharedNoise known(noise, values);
  for (const auto& [key, rows] : shared) {
    double least = sigma(rows[0]);
    for (const Index row : rows) least = std::min(least, sigma(row));
    // Its deviation over that of each reading, beside what is known of it.
    MatrixXd column = MatrixXd::Zero(static_cast<Index>(values.size()), 1);
    for (const Index row : rows) column(row, 0) = least / sigma(row);
    known.whiten(column);
    VectorXd zero = column(rows, 0);
    way.log_determinant += std::log1p(zero.squaredNorm());
    way.blocks.push_back({rows, std::move(zero)});
  }
  ways_.push_back(std::move(way));
}

void CorrelatedNoise::add_fading(const Campaign& campaign, const std::vector<Value>& values) {
  std::map<std::pair<std::size_t, Index>, Rows> tracks;
  for (std::size_t v = 0; v < values.size(); ++v) {
    const Reading& reading = campaign.readings[values[v].reading];
    if (!reading.time) return;
    tracks[{reading.session, values[v].component}].push_back(static_cast<Index>(v));
  }
  const auto order = [&](Index row) {
    const Reading& r = campaign.readings[values[static_cast<std::size_t>(row)].reading];
    return std::tuple(*r.time, r.cycle, r.step.value_or(0), r.id);
  };
  for (const double fading : {0.3, 0.6, 0.85}) {
    Way way{.what = "the error of a reading is like that of the one before it", .fading = fading};
    for (auto& [key, rows] : tracks) {
      std::stable_sort(rows.begin(), rows.end(),
                       [&](Index a, Index b) { return order(a) < order(b); });
      way.blocks.push_back({rows});
      way.log_determinant += static_cast<double>(rows.size() - 1) * std::log1p(-fading * fading);
    }
    ways_.push_back(std::move(way));
  }
}

MatrixXd CorrelatedNoise::decorrelated(std::size_t number, const MatrixXd& columns) const {
  const Way& way = ways_.at(number);
  MatrixXd result = columns;
  for (const Block& block : way.blocks) {
    if (block.zero.size() > 0) {  // the inverse of the symmetric root of 1 + zero zero'
      const VectorXd& zero = block.zero;
      const double less = (1 - 1 / std::sqrt(1 + zero.squaredNorm())) / zero.squaredNorm();
      const MatrixXd part = columns(block.rows, Eigen::all);
      result(block.rows, Eigen::all) = part - less * zero * (zero.transpose() * part);
      continue;
    }
    const double fresh = std::sqrt(1 - way.fading * way.fading);
    for (std::size_t i = 1; i < block.rows.size(); ++i)
      result.row(block.rows[i]) =
          (columns.row(block.rows[i]) - way.fading * columns.row(block.rows[i - 1])) / fresh;
  }
  return result;
}

std::vector<double> CorrelatedNoise::log_evidences(const BaseFit& fit) const {
  std::vector<double> logs(ways_.size(), 0);
  const ResidualSpace space(-fit.at.residual, fit.at.jacobian);
  const VectorXd residual = space.left_of(space.residual());
  if (space.dimension() < 1 || residual.isZero(0)) return logs;
  for (std::size_t way = 0; way < ways_.size(); ++way) {
    const MatrixXd basis = decorrelated(way, space.basis());
    VectorXd left = decorrelated(way, residual);
    double log = -0.5 * ways_[way].log_determinant;
    if (basis.cols() > 0) {
      const Eigen::HouseholderQR<MatrixXd> qr(basis);
      log -= qr.matrixQR().diagonal().cwiseAbs().array().log().sum();
      const MatrixXd q = qr.householderQ() * MatrixXd::Identity(basis.rows(), basis.cols());
      left -= (q * (q.transpose() * left)).eval();
    }
    logs[way] =
        log - static_cast<double>(space.dimension()) * std::log(left.norm() / residual.norm());
  }
  return logs;
}

double CorrelatedNoise::share_left(const BaseFit& without, const BaseFit& with) const {
  const std::optional<std::size_t> way = prevailing(with);
  const auto excess = [&](const BaseFit& fit) {
    return squared_error(fit, way) - static_cast<double>(with.degrees_of_freedom());
  };
  const double before = excess(without), after = std::max(0.0, excess(with));
  if (before > 0) return after / before;
  return after > 0 ? 1 : 0;
}

double CorrelatedNoise::squared_error(const BaseFit& fit, std::optional<std::size_t> way) const {
  if (!way) return fit.squared_error;
  return ResidualSpace(decorrelated(*way, -fit.at.residual), decorrelated(*way, fit.at.jacobian))
      .residual()
      .squaredNorm();
}

double CorrelatedNoise::gain(const BaseFit& fit) const {
  if (ways_.empty()) return 0;
  const double correlated = log_mean_exp(log_evidences(fit));
  return std::max(0.0, correlated) + std::log1p(std::exp(-std::abs(correlated)));
}

std::optional<std::size_t> CorrelatedNoise::prevailing(const BaseFit& fit) const {
  const std::vector<double> logs = log_evidences(fit);
  const auto most = std::max_element(logs.begin(), logs.end());
  if (most == logs.end() || *most <= out_of_question) return std::nullopt;
  return static_cast<std::size_t>(most - logs.begin());
}

}  // namespace kinetostat::calibration
