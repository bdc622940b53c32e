#include "kinetostat/calibration/campaign/datum.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool is_zero(const Reading& reading) {
  const std::vector<Index> used = components_in_use(reading);
  return std::all_of(used.begin(), used.end(),
                     [&](Index k) { return reading.displacement[k] == 0; });
}

VectorXd usual_sigma(const std::vector<std::size_t>& readings, const std::vector<VectorXd>& sigma) {
  VectorXd least =
      VectorXd::Constant(sigma[readings.front()].size(), std::numeric_limits<double>::infinity());
  for (const std::size_t i : readings)
    for (Index k = 0; k < least.size(); ++k)
      if (sigma[i][k] < least[k]) least[k] = sigma[i][k];
  return least.unaryExpr(
      [](double s) { return std::isfinite(s) ? std::sqrt(usual_datum_variance) * s : 0; });
}

// In a plan nothing is read yet.
bool is_read(const Campaign& campaign) {
  return !std::all_of(campaign.readings.begin(), campaign.readings.end(), is_zero);
}

// Of poses; nothing is counted from a reading there.
std::vector<Datum> stops_of_drives(const Campaign& campaign) {
  VectorXd sigma = VectorXd::Zero(campaign.size());
  for (Index k = 0; k < sigma.size(); ++k)
    if (campaign.sensors[campaign.component(k).sensor].is_platform() &&
        !std::isnan(campaign.datum_noise[k]))
      sigma[k] = campaign.datum_noise[k];
  std::vector<Datum> stops;
  if (sigma.isZero(0)) return stops;
  const std::vector<std::size_t> approaches = approaches_of(campaign);
  std::map<std::size_t, std::vector<std::size_t>> readings;
  for (std::size_t i = 0; i < approaches.size(); ++i)
    if (is_used(campaign.readings[i])) readings[approaches[i]].push_back(i);
  for (auto& [approach, own] : readings) stops.push_back({std::move(own), sigma});
  return stops;
}

bool has_datums(const Campaign& campaign) {
  return campaign.displacement == DisplacementKind::difference &&
         campaign.zero == ZeroReading::known;
}

}  // namespace

std::vector<bool> are_datums(const Campaign& campaign) {
  std::vector<bool> result(campaign.readings.size(), false);
  if (!has_datums(campaign) || !is_read(campaign)) return result;
  std::map<std::tuple<std::size_t, std::string, std::size_t>, std::size_t> first;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& r = campaign.readings[i];
    if (r.cycle.empty()) continue;
    const auto [at, is_new] = first.try_emplace({r.session, r.cycle, r.configuration}, i);
    const Reading& before = campaign.readings[at->second];
    if (!is_new && std::tuple(r.step, r.time) < std::tuple(before.step, before.time))
      at->second = i;
  }
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  for (const auto& [key, i] : first) {
    const Reading& reading = campaign.readings[i];
    result[i] = is_used(reading) && level_of(loads[i]) == 0 && is_zero(reading);
  }
  return result;
}

std::vector<std::size_t> approaches_of(const Campaign& campaign) {
  std::vector<Cycle> runs = cycles_as_run(campaign);
  std::map<std::size_t, Cycle> others;  // of sessions
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (const Reading& r = campaign.readings[i]; r.cycle.empty()) others[r.session].push_back(i);
  for (auto& [session, rows] : others) runs.push_back(std::move(rows));
  std::vector<std::size_t> approaches(campaign.readings.size());
  const std::vector<Cycle> stretches = stretches_of(campaign, runs);
  for (std::size_t i = 0; i < stretches.size(); ++i)
    for (const std::size_t reading : stretches[i]) approaches[reading] = i;
  return approaches;
}

std::vector<Datum> datums_of(const Campaign& campaign, const std::vector<VectorXd>& sigma) {
  if (campaign.displacement == DisplacementKind::absolute) return stops_of_drives(campaign);
  if (!has_datums(campaign)) return {};
  const bool is_measured = is_read(campaign);
  std::map<std::tuple<std::size_t, std::string, std::size_t>, std::vector<std::size_t>> counted;
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Reading& reading = campaign.readings[i];
    const bool is_datum = is_measured && level_of(reading.load) == 0 && is_zero(reading);
    if (is_used(reading) && !is_datum)
      counted[{reading.session, reading.cycle, reading.configuration}].push_back(i);
  }
  std::vector<Datum> datums;
  for (const auto& [key, readings] : counted) {
    VectorXd deviation = usual_sigma(readings, sigma);
    // One reading alone shares its datum with none: what is usual is taken for part of its noise.
    if (readings.size() == 1) deviation.setZero();
    for (Index k = 0; k < deviation.size(); ++k)
      if (!std::isnan(campaign.datum_noise[k])) deviation[k] = campaign.datum_noise[k];
    if (readings.size() > 1 || !deviation.isZero(0)) datums.push_back({readings, deviation});
  }
  return datums;
}

void whiten_singly(const Noise& noise, const std::vector<Value>& values,
                   Eigen::Ref<MatrixXd> rows) {
  for (std::size_t first = 0, next = 0; first < values.size(); first = next) {
    const std::size_t reading = values[first].reading;
    std::vector<Index> used;
    for (next = first; next < values.size() && values[next].reading == reading;)
      used.push_back(values[next++].component);
    noise.whiten(reading, used, rows.middleRows(static_cast<Index>(first), std::ssize(used)));
  }
}

SharedNoise::SharedNoise(const Noise& noise, const std::vector<Value>& values) {
  const auto is_exact = [](const Datum& datum) { return datum.sigma.isZero(0); };
  if (std::all_of(noise.datums.begin(), noise.datums.end(), is_exact)) return;
  std::map<std::size_t, std::vector<Index>> rows_of;
  for (std::size_t v = 0; v < values.size(); ++v)
    rows_of[values[v].reading].push_back(static_cast<Index>(v));
  for (const Datum& datum : noise.datums) {
    if (is_exact(datum)) continue;
    std::vector<Index> rows;
    for (const std::size_t reading : datum.readings)
      if (const auto found = rows_of.find(reading); found != rows_of.end())
        rows.insert(rows.end(), found->second.begin(), found->second.end());
    if (!rows.empty()) add(datum, noise, values, std::move(rows));
  }
}

// With Z Z' = U S^2 U' the powers of I + Z Z' differ from I by U f(S) U'.
void SharedNoise::add(const Datum& datum, const Noise& noise, const std::vector<Value>& values,
                      std::vector<Index> rows) {
  MatrixXd z = MatrixXd::Zero(static_cast<Index>(rows.size()), datum.sigma.size());
  std::vector<Value> own;
  for (const Index row : rows) {
    own.push_back(values[static_cast<std::size_t>(row)]);
    z(std::ssize(own) - 1, own.back().component) = datum.sigma[own.back().component];
  }
  whiten_singly(noise, own, z);
  const spatial::SymmetricEigen eigen = spatial::symmetric_eigen(z.transpose() * z);
  std::vector<Index> kept;
  for (Index k = 0; k < eigen.values.size(); ++k)
    if (eigen.values[k] > 1e-12) kept.push_back(k);
  if (kept.empty()) return;
  const VectorXd squares = eigen.values(kept), roots = (1 + squares.array()).sqrt();
  blocks_.push_back(
      {std::move(rows),
       z * eigen.vectors(Eigen::all, kept) * squares.cwiseSqrt().cwiseInverse().asDiagonal(),
       (1 - roots.array().inverse()).matrix(), (roots.array() - 1).matrix()});
}

void SharedNoise::whiten(Eigen::Ref<MatrixXd> rows) const {
  for (const Block& block : blocks_) {
    const MatrixXd part = rows(block.rows, Eigen::all);
    rows(block.rows, Eigen::all) =
        part - block.u * (block.less.asDiagonal() * (block.u.transpose() * part)).eval();
  }
}

void SharedNoise::restore(Eigen::Ref<MatrixXd> rows) const {
  for (const Block& block : blocks_) {
    const MatrixXd part = rows(block.rows, Eigen::all);
    rows(block.rows, Eigen::all) =
        part + block.u * (block.more.asDiagonal() * (block.u.transpose() * part)).eval();
  }
}

VectorXd SharedNoise::deviations(Index rows) const {
  VectorXd variances = VectorXd::Ones(rows);
  for (const Block& block : blocks_) {
    const VectorXd squares = (1 + block.more.array()).square() - 1;
    variances(block.rows) += block.u.cwiseAbs2() * squares;
  }
  return variances.cwiseSqrt();
}

double SharedNoise::log_determinant() const {
  double sum = 0;
  for (const Block& block : blocks_) sum += 2 * block.more.array().log1p().sum();
  return sum;
}

}  // namespace kinetostat::calibration
