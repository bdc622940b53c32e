#include "kinetostat/calibration/search/correlated_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include <Eigen/QR>
#include <fmt/format.h>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/regression/evidence.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double out_of_question = 6.9;  // of log evidence: a thousand to one

}  // namespace

CorrelatedNoise::CorrelatedNoise(const Campaign& campaign, const std::vector<Value>& values,
                                 const Noise& noise) {
  if (campaign.displacement == DisplacementKind::difference)
    add_zeros(campaign, values, noise);
  else
    add_approaches(campaign, values, noise);
  add_fading(campaign, values);
}

void CorrelatedNoise::add_zeros(const Campaign& campaign, const std::vector<Value>& values,
                                const Noise& noise) {
  std::map<std::tuple<std::size_t, std::string, std::size_t>, std::size_t> known;
  std::vector<std::size_t> zeros;
  bool in_cycles = false;
  for (const Value& value : values) {
    const Reading& reading = campaign.readings[value.reading];
    in_cycles |= !reading.cycle.empty();
    const std::size_t configuration = reading.cycle.empty() ? reading.configuration : 0;
    zeros.push_back(known.try_emplace({reading.session, reading.cycle, configuration}, known.size())
                        .first->second);
  }
  add_shared({.what = fmt::format("readings of one {} are off together, as the noise of the one "
                                  "reading without load that they are counted from makes them",
                                  in_cycles ? "cycle" : "configuration")},
             zeros, 1, values, noise);
}

void CorrelatedNoise::add_approaches(const Campaign& campaign, const std::vector<Value>& values,
                                     const Noise& noise) {
  const std::vector<std::size_t> of_readings = approaches_of(campaign);
  std::vector<std::size_t> approaches;
  approaches.reserve(values.size());
  for (const Value& value : values) approaches.push_back(of_readings[value.reading]);
  const std::array sizes = {std::pair(0.5, "half"), std::pair(1.0, "about"),
                            std::pair(2.0, "twice"), std::pair(4.0, "four times")};
  for (const auto& [times, words] : sizes)
    add_shared({.what = fmt::format("readings of one approach to a posture are off together by {} "
                                    "the noise of one, as drives make them that stop a little "
                                    "elsewhere each time ('repeatability' states that)",
                                    words),
                .share = 1.0 / static_cast<double>(sizes.size())},
               approaches, times, values, noise);
}

// `datums`: of each value, which error it shares with others of its component, of so many times the
// least noise of them.
void CorrelatedNoise::add_shared(Way way, const std::vector<std::size_t>& datums, double times,
                                 const std::vector<Value>& values, const Noise& noise) {
  std::map<std::pair<std::size_t, Index>, Rows> shared;
  for (std::size_t v = 0; v < values.size(); ++v)
    shared[{datums[v], values[v].component}].push_back(static_cast<Index>(v));
  if (std::all_of(shared.begin(), shared.end(), [](const auto& s) { return s.second.size() < 2; }))
    return;
  const auto sigma = [&](Index row) {
    const Value& value = values[static_cast<std::size_t>(row)];
    return noise.sigma[value.reading][value.component];
  };
  const SharedNoise known(noise, values);
  for (const auto& [key, rows] : shared) {
    double least = sigma(rows[0]);
    for (const Index row : rows) least = std::min(least, sigma(row));
    // Its deviation over that of each reading, beside what is known of it.
    MatrixXd column = MatrixXd::Zero(static_cast<Index>(values.size()), 1);
    for (const Index row : rows) column(row, 0) = times * least / sigma(row);
    known.whiten(column);
    VectorXd zero = column(rows, 0);
    way.log_determinant += std::log1p(zero.squaredNorm());
    way.blocks.push_back({rows, std::move(zero), key.first});
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

MatrixXd CorrelatedNoise::decorrelated(std::size_t way, const MatrixXd& columns) const {
  return decorrelated(ways_.at(way), columns);
}

MatrixXd CorrelatedNoise::decorrelated(const Way& way, const MatrixXd& columns) {
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

double CorrelatedNoise::log_evidence(const Way& way, const ResidualSpace& space) {
  const VectorXd residual = space.left_of(space.residual());
  if (space.dimension() < 1 || residual.isZero(0)) return 0;
  const MatrixXd basis = decorrelated(way, space.basis());
  VectorXd left = decorrelated(way, residual);
  double log = -0.5 * way.log_determinant;
  if (basis.cols() > 0) {
    const Eigen::HouseholderQR<MatrixXd> qr(basis);
    log -= qr.matrixQR().diagonal().cwiseAbs().array().log().sum();
    const MatrixXd q = qr.householderQ() * MatrixXd::Identity(basis.rows(), basis.cols());
    left -= (q * (q.transpose() * left)).eval();
  }
  return log - static_cast<double>(space.dimension()) * std::log(left.norm() / residual.norm());
}

namespace {

// Of the unknowns that may move: one that a bound holds explains nothing of a residual.
MatrixXd free_columns(const BaseFit& fit) {
  std::vector<Index> free;
  for (Index k = 0; k < fit.at.jacobian.cols(); ++k)
    if (const auto p = static_cast<std::size_t>(k);
        p >= fit.parameters.size() || fit.parameters[p].hit == BoundHit::none)
      free.push_back(k);
  return fit.at.jacobian(Eigen::all, free);
}

}  // namespace

std::vector<double> CorrelatedNoise::log_evidences(const BaseFit& fit) const {
  const ResidualSpace space(-fit.at.residual, free_columns(fit));
  std::vector<double> logs;
  for (const Way& way : ways_) logs.push_back(log_evidence(way, space));
  return logs;
}

// Without the readings of the datum that is farthest off; nullopt where there are few.
std::optional<double> CorrelatedNoise::log_without_worst(const Way& way, const BaseFit& fit) {
  constexpr std::size_t few = 5;
  const MatrixXd columns = free_columns(fit);
  const ResidualSpace space(-fit.at.residual, columns);
  const VectorXd residual = space.left_of(space.residual());
  std::vector<double> pull;
  for (const Block& block : way.blocks) {
    pull.resize(std::max(pull.size(), block.datum + 1), 0);
    if (block.zero.size() > 0)
      pull[block.datum] +=
          std::pow(block.zero.dot(residual(block.rows)), 2) / (1 + block.zero.squaredNorm());
  }
  if (pull.size() < few) return std::nullopt;
  const auto worst =
      static_cast<std::size_t>(std::max_element(pull.begin(), pull.end()) - pull.begin());
  Way rest{.what = {}, .fading = way.fading};
  Rows kept;
  for (const Block& block : way.blocks) {
    if (block.datum == worst) continue;
    Block moved = block;
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      moved.rows[i] = std::ssize(kept);
      kept.push_back(block.rows[i]);
    }
    rest.log_determinant += std::log1p(block.zero.squaredNorm());
    rest.blocks.push_back(std::move(moved));
  }
  return log_evidence(rest, ResidualSpace(-fit.at.residual(kept), columns(kept, Eigen::all)));
}

// With noise of datums as far as each of them shows it.
std::vector<double> CorrelatedNoise::believed(const BaseFit& fit, std::vector<double> logs) const {
  for (std::size_t way = 0; way < ways_.size(); ++way) {
    if (ways_[way].fading > 0 || !(logs[way] > 0)) continue;
    if (const auto rest = log_without_worst(ways_[way], fit))
      logs[way] = std::min(logs[way], *rest);
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

double CorrelatedNoise::squared_error_where_shared(const BaseFit& fit,
                                                   std::optional<std::size_t> way) const {
  const bool shared = way && ways_[*way].fading == 0;
  return squared_error(fit, shared ? way : std::nullopt);
}

double CorrelatedNoise::squared_error(const BaseFit& fit, std::optional<std::size_t> way) const {
  if (!way) return fit.squared_error;
  return ResidualSpace(decorrelated(*way, -fit.at.residual), decorrelated(*way, free_columns(fit)))
      .residual()
      .squaredNorm();
}

double CorrelatedNoise::gain(const BaseFit& fit) const {
  if (ways_.empty()) return 0;
  std::vector<double> logs = believed(fit, log_evidences(fit));
  double shares = 0;
  for (std::size_t way = 0; way < ways_.size(); ++way) {
    shares += ways_[way].share;
    logs[way] += std::log(ways_[way].share);
  }
  const double correlated =
      log_mean_exp(logs) + std::log(static_cast<double>(ways_.size()) / shares);
  return std::max(0.0, correlated) + std::log1p(std::exp(-std::abs(correlated)));
}

std::optional<std::size_t> CorrelatedNoise::prevailing(const BaseFit& fit) const {
  const std::vector<double> logs = log_evidences(fit), belief = believed(fit, logs);
  std::optional<std::size_t> most;
  for (std::size_t way = 0; way < logs.size(); ++way)
    if (belief[way] > out_of_question && (!most || logs[way] > logs[*most])) most = way;
  return most;
}

}  // namespace kinetostat::calibration
