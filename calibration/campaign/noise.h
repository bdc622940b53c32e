// How exact the readings are. Never taken from the residual of a model.
#pragma once

#include <memory>
#include <vector>

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::calibration {

enum class NoiseSource {
  stated,      // by the campaign file or its sigma columns
  replicates,  // pooled scatter of repeated readings, each kind of component apart
  unknown      // neither: residuals are not weighted, and no test of adequacy is possible
};

/// Readings that are counted from one reading of the unloaded state: they share its error.
struct Datum {
  std::vector<std::size_t> readings;
  Eigen::VectorXd sigma;  // standard deviation of that one reading, one entry a component
};

struct Noise {
  NoiseSource source = NoiseSource::unknown;
  /// Standard deviations by which residuals are divided, one entry a reading and component, SI.
  /// With an unknown noise they are 1.
  std::vector<Eigen::VectorXd> sigma;
  /// Between components, one entry a reading (nullptr: independent); empty: all are.
  std::vector<std::shared_ptr<const Eigen::MatrixXd>> correlation = {};
  std::vector<Datum> datums = {};  // disjoint; beside `sigma`, which is that of each reading alone
  /// False when components of several kinds (translations, rotations) are measured and nothing says
  /// how their errors compare: then they cannot enter one sum of squares.
  bool comparable = true;
  /// No replicate is under load, though other readings are.
  bool only_unloaded = false;
  /// On which the estimate rests; 0 where the noise is stated or unknown.
  Eigen::Index degrees_of_freedom = 0;

  /// Divides rows that belong to the components `used` of a reading (residuals, derivatives) by its
  /// noise; correlated components by the Cholesky factor of their covariance. What readings share
  /// stays in: see SharedNoise.
  void whiten(std::size_t reading, const std::vector<Eigen::Index>& used,
              Eigen::Ref<Eigen::MatrixXd> rows) const;
};

}  // namespace kinetostat::calibration
