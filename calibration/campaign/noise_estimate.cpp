#include "kinetostat/calibration/campaign/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinetostat/calibration/campaign/datum.h"
#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/calibration/campaign/pure_error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

bool measures(const Campaign& campaign, const std::vector<Index>& kind) {
  return std::any_of(campaign.readings.begin(), campaign.readings.end(), [&](const Reading& r) {
    return std::any_of(kind.begin(), kind.end(), [&](Index k) { return r.uses(k); });
  });
}

void add_correlations(const Campaign& campaign, Noise& noise) {
  if (campaign.correlations.empty()) return;
  std::vector<std::shared_ptr<const Eigen::MatrixXd>> distinct;
  for (const Eigen::MatrixXd& correlation : campaign.correlations)
    distinct.push_back(std::make_shared<const Eigen::MatrixXd>(correlation));
  for (const Reading& reading : campaign.readings)
    noise.correlation.push_back(reading.correlation ? distinct[*reading.correlation] : nullptr);
}

bool are_only_unloaded(const Campaign& campaign, const std::vector<ReplicateGroup>& groups) {
  const bool any_loaded =
      std::any_of(campaign.readings.begin(), campaign.readings.end(),
                  [](const Reading& r) { return is_used(r) && level_of(r.load) > 0; });
  return any_loaded && std::none_of(groups.begin(), groups.end(), [&](const ReplicateGroup& group) {
           return group.readings.size() > 1 &&
                  level_of(campaign.readings[group.readings[0]].load) > 0;
         });
}

void scale(Noise& noise, const Campaign& campaign, const std::vector<Index>& kind, double factor) {
  for (VectorXd& sigma : noise.sigma) sigma(kind) *= factor;
  for (Datum& datum : noise.datums)
    for (const Index k : kind)
      if (std::isnan(campaign.datum_noise[k])) datum.sigma[k] *= factor;
}

}  // namespace

// What a stated datum shares does not grow with the noise, so that the scatter beside it is not
// proportional: iterated.
Noise with_scatter(Noise noise, const Campaign& campaign,
                   const std::vector<ReplicateGroup>& groups) {
  if (noise.source != NoiseSource::replicates) return noise;
  constexpr int most_steps = 100;
  constexpr double exactly = 1e-6;
  for (const std::vector<Index>& kind : component_kinds(campaign)) {
    if (!measures(campaign, kind)) continue;
    for (int step = 0; step < most_steps; ++step) {
      const PureError scatter = pure_error(campaign, groups, noise, kind);
      if (scatter.degrees_of_freedom == 0 || !(scatter.sum > 0)) break;
      const double factor =
          std::sqrt(scatter.sum / static_cast<double>(scatter.degrees_of_freedom));
      scale(noise, campaign, kind, factor);
      if (std::abs(factor - 1) < exactly) break;
    }
  }
  return noise;
}

Noise noise_of(const Campaign& campaign, const std::vector<ReplicateGroup>& groups) {
  Noise noise;
  if (campaign.noise_stated) {
    noise.source = NoiseSource::stated;
    for (const Reading& reading : campaign.readings) noise.sigma.push_back(reading.sigma);
    add_correlations(campaign, noise);
    noise.datums = datums_of(campaign, noise.sigma);
    return noise;
  }
  noise.sigma.assign(campaign.readings.size(), VectorXd::Ones(campaign.size()));
  noise.datums = datums_of(campaign, noise.sigma);
  bool complete = true;
  Index freedom = 0, kinds = 0;
  for (const std::vector<Index>& kind : component_kinds(campaign)) {
    if (!measures(campaign, kind)) continue;
    ++kinds;
    const PureError scatter = pure_error(campaign, groups, noise, kind);
    const bool usable = scatter.degrees_of_freedom > 0 && scatter.sum > 0;
    complete = complete && usable;
    if (usable) freedom += scatter.degrees_of_freedom;
  }
  noise.comparable = complete || kinds < 2;
  if (!complete) {
    noise.datums.clear();
    return noise;
  }
  noise.source = NoiseSource::replicates;
  noise.only_unloaded = are_only_unloaded(campaign, groups);
  noise.degrees_of_freedom = freedom;
  return with_scatter(std::move(noise), campaign, groups);
}

}  // namespace kinetostat::calibration
