#include "kinetostat/calibration/campaign/pure_error.h"

#include <map>
#include <utility>

namespace kinetostat::calibration {

PureError pure_error(const Campaign& campaign, const std::vector<ReplicateGroup>& groups,
                     const Noise& noise, Eigen::Index first, Eigen::Index count) {
  PureError result;
  // Deviations from the weighted means, by reading.
  std::map<std::size_t, std::pair<std::vector<Eigen::Index>, std::vector<double>>> deviations;
  for (const ReplicateGroup& group : groups) {
    const Eigen::Index k = group.component;
    if (k < first || k >= first + count || group.readings.size() < 2) continue;
    double weights = 0, mean = 0;
    for (const std::size_t i : group.readings) {
      const double weight = 1 / (noise.sigma[i][k] * noise.sigma[i][k]);
      weights += weight;
      mean += weight * campaign.readings[i].displacement[k];
    }
    mean /= weights;
    for (const std::size_t i : group.readings) {
      deviations[i].first.push_back(k);
      deviations[i].second.push_back(campaign.readings[i].displacement[k] - mean);
    }
    result.degrees_of_freedom += static_cast<Eigen::Index>(group.readings.size()) - 1;
  }
  for (auto& [reading, entry] : deviations) {
    auto& [components, values] = entry;
    Eigen::MatrixXd column =
        Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    noise.whiten(reading, components, column);
    result.sum += column.squaredNorm();
  }
  return result;
}

std::optional<ChiSquareTest> test_of_stated_noise(const PureError& scatter, const Noise& noise) {
  if (noise.source != NoiseSource::stated || scatter.degrees_of_freedom == 0) return std::nullopt;
  return chi_square_test(scatter.sum, scatter.degrees_of_freedom);
}

}  // namespace kinetostat::calibration
