// How exact the readings are. Never taken from the residual of a model.
#pragma once

#include <memory>
#include <vector>

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::calibration {

enum class NoiseSource {
  stated,      // by the campaign file or its sigma columns
  replicates,  // pooled scatter of repeated readings, translations and rotations apart
  unknown      // neither: residuals are not weighted, and no test of adequacy is possible
};

struct Noise {
  NoiseSource source = NoiseSource::unknown;
  /// Standard deviations by which residuals are divided [m; rad], one entry a reading. With an
  /// unknown noise they are 1.
  std::vector<spatial::Vector6> sigma;
  /// Between components, one entry a reading (nullptr: independent); empty: all are.
  std::vector<std::shared_ptr<const spatial::Matrix6>> correlation = {};
  /// False when translations and rotations are measured together and nothing says how their errors
  /// compare: then they cannot enter one sum of squares.
  bool comparable = true;
  /// No replicate is under load, though other readings are.
  bool only_unloaded = false;
  /// On which the estimate rests; 0 where the noise is stated or unknown.
  Eigen::Index degrees_of_freedom = 0;

  /// Divides rows that belong to the components `used` of a reading (residuals, derivatives) by its
  /// noise; correlated components by the Cholesky factor of their covariance.
  void whiten(std::size_t reading, const std::vector<Eigen::Index>& used,
              Eigen::Ref<Eigen::MatrixXd> rows) const;
};

}  // namespace kinetostat::calibration
