#include "kinetostat/calibration/campaign/pure_error.h"

#include <algorithm>
#include <map>
#include <utility>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What the datums of readings add to the scatter y of one component about its group means, at one
// configuration. With the covariance I + Z Z' of the readings, and the projector M on what group
// means leave,
//
//   y' (M - M Z (I + Z' M Z)^-1 Z' M) y
//
// is the scatter beside them (generalised least squares): this is the second term.
class DatumScatter {
 public:
  // `datum`: of each reading, or nullptr.
  DatumScatter(const Noise& noise, Index component, const std::vector<const Datum*>& datum)
      : noise_(noise), component_(component), datum_(datum) {}

  // `deviations` [m or rad] from the weighted mean of the group.
  void add(const std::vector<std::size_t>& readings, const std::vector<double>& deviations) {
    double weights = 0;
    std::map<Index, double> shares;  // Z' u with the direction u of the mean, by datum
    for (std::size_t r = 0; r < readings.size(); ++r) {
      const double sigma = noise_.sigma[readings[r]][component_];
      weights += 1 / (sigma * sigma);
      const Datum* datum = datum_[readings[r]];
      if (datum == nullptr) continue;
      const Index d = index_.try_emplace(datum, std::ssize(index_)).first->second;
      const double z = datum->sigma[component_] / sigma;
      along_[d] += z * deviations[r] / sigma;
      gram_[{d, d}] += z * z;
      shares[d] += z / sigma;
    }
    for (const auto& [a, x] : shares)
      for (const auto& [b, y] : shares) gram_[{a, b}] -= x * y / weights;
  }

  double sum() const {
    const auto count = static_cast<Index>(index_.size());
    VectorXd along = VectorXd::Zero(count);
    MatrixXd gram = MatrixXd::Identity(count, count);
    for (const auto& [d, value] : along_) along[d] += value;
    for (const auto& [entry, value] : gram_) gram(entry.first, entry.second) += value;
    return count == 0 ? 0 : along.dot(spatial::solve_symmetric(gram, along).col(0));
  }

 private:
  const Noise& noise_;
  Index component_;
  const std::vector<const Datum*>& datum_;
  std::map<const Datum*, Index> index_;
  std::map<Index, double> along_;
  std::map<std::pair<Index, Index>, double> gram_;
};

std::vector<const Datum*> datum_of_each(const Campaign& campaign, const Noise& noise) {
  std::vector<const Datum*> result(campaign.readings.size(), nullptr);
  for (const Datum& datum : noise.datums)
    for (const std::size_t i : datum.readings) result[i] = &datum;
  return result;
}

}  // namespace

PureError pure_error(const Campaign& campaign, const std::vector<ReplicateGroup>& groups,
                     const Noise& noise, const std::vector<Eigen::Index>& components) {
  PureError result;
  // Deviations from the weighted means, by reading.
  std::map<std::size_t, std::pair<std::vector<Eigen::Index>, std::vector<double>>> deviations;
  const std::vector<const Datum*> datum = datum_of_each(campaign, noise);
  std::map<std::pair<Index, std::size_t>, DatumScatter> shared;  // by component and configuration
  for (const ReplicateGroup& group : groups) {
    const Index k = group.component;
    const bool counts = components.empty() ||
                        std::find(components.begin(), components.end(), k) != components.end();
    if (!counts || group.readings.size() < 2) continue;
    double weights = 0, mean = 0;
    for (const std::size_t i : group.readings) {
      const double weight = 1 / (noise.sigma[i][k] * noise.sigma[i][k]);
      weights += weight;
      mean += weight * campaign.readings[i].displacement[k];
    }
    mean /= weights;
    std::vector<double> from_mean;
    for (const std::size_t i : group.readings) {
      from_mean.push_back(campaign.readings[i].displacement[k] - mean);
      deviations[i].first.push_back(k);
      deviations[i].second.push_back(from_mean.back());
    }
    if (!noise.datums.empty())
      shared.try_emplace({k, campaign.readings[group.readings[0]].configuration}, noise, k, datum)
          .first->second.add(group.readings, from_mean);
    result.degrees_of_freedom += static_cast<Eigen::Index>(group.readings.size()) - 1;
  }
  for (auto& [reading, entry] : deviations) {
    auto& [used, values] = entry;
    Eigen::MatrixXd column =
        Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    noise.whiten(reading, used, column);
    result.sum += column.squaredNorm();
  }
  for (const auto& [key, scatter] : shared) result.sum -= scatter.sum();
  return result;
}

std::optional<ChiSquareTest> test_of_stated_noise(const PureError& scatter, const Noise& noise) {
  if (noise.source != NoiseSource::stated || scatter.degrees_of_freedom == 0) return std::nullopt;
  return chi_square_test(scatter.sum, scatter.degrees_of_freedom);
}

}  // namespace kinetostat::calibration
