#include "kinetostat/calibration/structure.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/normal.h"
#include "kinetostat/files/parallel.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_rows = 1500;

// One row a reading; columns that do not vary are left out, the others have unit variance.
MatrixXd standardised(const MatrixXd& features) {
  MatrixXd result(features.rows(), features.cols());
  Index kept = 0;
  for (Index j = 0; j < features.cols(); ++j) {
    const double mean = features.col(j).mean();
    const double deviation = std::sqrt((features.col(j).array() - mean).square().mean());
    if (!(deviation > 1e-9 * (std::abs(mean) + 1e-300))) continue;
    result.col(kept++) = (features.col(j).array() - mean) / deviation;
  }
  return result.leftCols(kept);
}

MatrixXd postures_of(const Campaign& campaign) {
  std::map<std::string, Index> joints;
  for (const Configuration& c : campaign.configurations)
    for (const auto& [name, value] : c.joints) joints.emplace(name, 0);
  Index next = 6;
  for (auto& [name, column] : joints) column = next++;
  MatrixXd features = MatrixXd::Zero(static_cast<Index>(campaign.readings.size()), next);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const Configuration& c = campaign.configurations[campaign.readings[i].configuration];
    const auto row = static_cast<Index>(i);
    if (c.target)
      features.row(row).head<6>() << c.target->position().transpose(),
          spatial::log_rotation(c.target->rotation()).transpose();
    for (const auto& [name, value] : c.joints) features(row, joints.at(name)) = value;
  }
  return standardised(features);
}

MatrixXd loads_of(const Campaign& campaign) {
  MatrixXd features(static_cast<Index>(campaign.readings.size()), 6);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i) {
    const vjm::Load& load = campaign.readings[i].load;
    features.row(static_cast<Index>(i)) << load.force.transpose(), load.moment.transpose();
  }
  // Not about their mean: the sign of a load matters.
  for (Index j = 0; j < 6; ++j) {
    const double size = features.col(j).cwiseAbs().maxCoeff();
    if (size > 0) features.col(j) /= size / 1.5;
  }
  return features;
}

MatrixXd numbers_of(const Campaign& campaign, std::optional<double> Reading::*member) {
  MatrixXd features = MatrixXd::Zero(static_cast<Index>(campaign.readings.size()), 1);
  for (std::size_t i = 0; i < campaign.readings.size(); ++i)
    features(static_cast<Index>(i), 0) = (campaign.readings[i].*member).value_or(0);
  return standardised(features);
}

}  // namespace

Structure::Structure(const Campaign& campaign, const std::vector<Value>& values) {
  const std::size_t step = std::max<std::size_t>(1, (values.size() + most_rows - 1) / most_rows);
  for (std::size_t i = 0; i < values.size(); i += step) rows_.push_back(static_cast<Index>(i));
  const MatrixXd postures = postures_of(campaign), loads = loads_of(campaign);
  if (postures.cols() > 0) add("posture", postures, values);
  if (!loads.isZero(0)) add("load", loads, values);
  if (postures.cols() > 0 && !loads.isZero(0)) {
    MatrixXd both(postures.rows(), postures.cols() + loads.cols());
    both << postures, loads;
    add("posture and load together", both, values);
  }
  const MatrixXd times = numbers_of(campaign, &Reading::time);
  if (times.cols() > 0) add("time", 3 * times, values);
  const MatrixXd temperatures = numbers_of(campaign, &Reading::temperature);
  if (temperatures.cols() > 0) add("temperature", temperatures, values);
}

// A squared exponential over the features of the readings, components apart. Its diagonal is the
// noise's as much as the kernel's and is left out.
void Structure::add(const std::string& name, const MatrixXd& features,
                    const std::vector<Value>& values) {
  const auto n = static_cast<Index>(rows_.size());
  MatrixXd kernel = MatrixXd::Zero(n, n);
  const auto value = [&](Index a) -> const Value& {
    return values[static_cast<std::size_t>(rows_[static_cast<std::size_t>(a)])];
  };
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < a; ++b) {
      const Value &x = value(a), &y = value(b);
      if (x.component != y.component) continue;
      kernel(a, b) = std::exp(-(features.row(static_cast<Index>(x.reading)) -
                                features.row(static_cast<Index>(y.reading)))
                                   .squaredNorm() /
                              2);
    }
  names_.push_back(name);
  kernels_.push_back(std::move(kernel));
}

VectorXd Structure::statistics(const VectorXd& residual) const {
  const VectorXd part = residual(rows_);
  VectorXd result(static_cast<Index>(kernels_.size()));
  const double size = part.squaredNorm();
  for (std::size_t k = 0; k < kernels_.size(); ++k)
    result[static_cast<Index>(k)] =
        size > 0 ? part.dot(kernels_[k].selfadjointView<Eigen::Lower>() * part) / size : 0;
  return result;
}

StructureTest structure_test(const Structure& structure, const ResidualSpace& space, int draws,
                             std::uint64_t seed, int threads) {
  const auto kernels = static_cast<Index>(structure.names().size());
  if (kernels == 0 || space.dimension() < 2) return {};
  MatrixXd simulated(kernels, draws);
  files::Progress silent;
  files::parallel_for(static_cast<std::size_t>(draws), threads, "", silent, [&](std::size_t d) {
    Normal normal(seed + d);
    VectorXd noise(space.residual().size());
    for (double& x : noise) x = normal();
    simulated.col(static_cast<Index>(d)) = structure.statistics(space.left_of(noise));
  });
  const VectorXd mean = simulated.rowwise().mean();
  const VectorXd deviation =
      ((simulated.colwise() - mean).array().square().rowwise().mean()).sqrt().max(1e-300);
  const VectorXd seen = (structure.statistics(space.residual()) - mean).cwiseQuotient(deviation);
  Index most = 0;
  const double largest = seen.maxCoeff(&most);
  int above = 0;
  for (Index d = 0; d < draws; ++d)
    above += ((simulated.col(d) - mean).cwiseQuotient(deviation)).maxCoeff() >= largest ? 1 : 0;
  return {.p_value = (1.0 + above) / (1.0 + draws),
          .depends_on = structure.names()[static_cast<std::size_t>(most)],
          .excess = largest};
}

}  // namespace kinetostat::calibration
