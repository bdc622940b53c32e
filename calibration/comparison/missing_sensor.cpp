#include "kinetostat/calibration/comparison/missing_sensor.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/sensors/sensor_places.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double tilt_noise = 5e-6, length_noise = 5e-6;  // [rad], [m]
constexpr double known_before = 10;
constexpr double determined = 0.2, decisive = 0.1;

// Derivatives of components by a change of each parameter that is worth knowing, over a deviation.
MatrixXd scaled(const MatrixXd& derivatives, const std::vector<Parameter>& parameters,
                const VectorXd& deviation) {
  MatrixXd result = derivatives.array().colwise() / deviation.array();
  for (Index k = 0; k < result.cols(); ++k)
    result.col(k) *= parameters[static_cast<std::size_t>(k)].typical;
  return result;
}

// Standard deviations by this information, over a change of each that is worth knowing.
VectorXd deviations(const MatrixXd& information) {
  const Index n = information.rows();
  const MatrixXd all = information + MatrixXd::Identity(n, n) / (known_before * known_before);
  return all.inverse().diagonal().cwiseSqrt();
}

// The campaign as a tilt sensor and a sensor of position at every place would see it.
Campaign with_sensors_everywhere(const Campaign& campaign, const std::vector<SensorPlace>& places) {
  Campaign all = campaign;
  const std::size_t base = all.watch.frames.size();  // behind where weights hang
  all.watch.frames.push_back({});
  all.sensors.clear();
  all.components.clear();
  for (const SensorPlace& place : places) {
    for (Index axis = 0; axis < 5; ++axis)
      all.components.push_back(
          {.name = place.name,
           .dimension = is_rotation(axis) ? spatial::dimension::angle : spatial::dimension::length,
           .sensor = all.sensors.size(),
           .axis = axis});
    all.sensors.push_back({.name = place.name, .frame = all.watch.frames.size(), .from = base});
    all.watch.frames.push_back(place.frame);
  }
  for (Reading& reading : all.readings) {
    reading.displacement.setConstant(all.size(), not_a_number);
    if (is_used(reading)) continue;
    reading.masked = true;
  }
  return all;
}

}  // namespace

std::string MissingSensor::kind_in_words() const {
  return tilt ? "tilt sensor" : "sensor of position (or dial gauges)";
}

std::string MissingSensor::phrase() const {
  return fmt::format(
      "a {} on '{}' ('sensors' in the campaign file), read under the same loads: it would "
      "determine "
      "{}, to about {:.2g} %",
      kind_in_words(), place, fmt::join(open, " and "), 100 * with);
}

std::optional<MissingSensor> missing_sensor(const vjm::Robot& robot,
                                            const std::vector<vjm::Effect>& effects,
                                            const std::vector<Parameter>& parameters,
                                            const Campaign& campaign, const Noise& noise,
                                            int threads, common::Progress& progress) {
  if (campaign.watch.is_empty() || parameters.empty() || noise.source == NoiseSource::unknown)
    return std::nullopt;
  const auto predict = [&](const Campaign& of) {
    return Predictor(robot.without_effects(), effects, of, threads, progress)
        .predict(parameters, starts_of(parameters), true, progress);
  };
  const Predictions here = predict(campaign);
  if (here.failure) return std::nullopt;
  const auto n = static_cast<Index>(parameters.size());
  MatrixXd information = MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    if (const auto used = components_in_use(campaign.readings[i]); !used.empty()) {
      const MatrixXd rows =
          scaled(here.derivatives[i](used, Eigen::all), parameters, noise.sigma[i](used));
      information += rows.transpose() * rows;
    }
  const VectorXd without = deviations(information);
  MissingSensor best;
  best.with = without.maxCoeff();
  for (Index k = 0; k < n; ++k)
    if (without[k] > determined)
      best.open.push_back(parameters[static_cast<std::size_t>(k)].phrase());
  if (best.open.empty()) return std::nullopt;
  const std::vector<SensorPlace> places = sensor_places(robot.without_effects());
  const Campaign everywhere = with_sensors_everywhere(campaign, places);
  const Predictions all = predict(everywhere);
  if (all.failure) return std::nullopt;
  for (std::size_t p = 0; p < places.size(); ++p)
    for (const bool tilt : {true, false}) {
      MatrixXd more = information;
      const Index first = 5 * static_cast<Index>(p) + (tilt ? 3 : 0), count = tilt ? 2 : 3;
      for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
        if (components_in_use(campaign.readings[i]).empty()) continue;
        const MatrixXd rows = scaled(all.derivatives[i].middleRows(first, count), parameters,
                                     VectorXd::Constant(count, tilt ? tilt_noise : length_noise));
        more += rows.transpose() * rows;
      }
      // The first of equals: tilt sensors, and places nearer the base.
      if (const double with = deviations(more).maxCoeff(); with < 0.8 * best.with)
        best.tilt = tilt, best.place = places[p].name, best.with = with;
    }
  if (best.place.empty() || best.with > std::max(determined, decisive * without.maxCoeff()))
    return std::nullopt;
  return best;
}

}  // namespace kinetostat::calibration
