// What a model predicts of the readings of a campaign.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/linear_algebra.h"
#include "kinetostat/vjm/statics/system_state.h"

namespace kinetostat::calibration {

/// A reading of which the model has no prediction.
struct PredictionFailure {
  std::size_t reading = 0;
  std::string reason;
};

/// One entry a reading, in the order of the campaign.
struct Predictions {
  /// What the sensors would read, one entry a component, SI: changes from the state without load
  /// (weight, preloads and geometric errors act in both), or what they read themselves. Rotation
  /// vectors and angles are those nearest to the measured among equivalent ones. NaN for a masked
  /// reading that fails.
  std::vector<Eigen::VectorXd> displacement;
  /// Its derivatives with respect to the parameters; empty when not asked for.
  std::vector<Eigen::MatrixXd> derivatives;
  /// Its change with the wrench [force; moment] of the reading, base axes, about the stated point,
  /// six columns: the compliance of the loaded robot as the campaign measures it. The part that a
  /// history carries on to later readings is not in it. Empty but from predict_with_compliance().
  std::vector<Eigen::MatrixXd> by_wrench;
  /// The stated wrench [force; moment about the target] as it works on the displacement of the
  /// platform, in its axes, at the predicted pose; 0 where the platform is not read.
  std::vector<spatial::Vector6> work;
  /// Equilibria under the load and without, from which those of a similar model are found quickly;
  /// those without load are left out where no force acts then. With `few_states` there is one entry
  /// a configuration, that of its first reading.
  std::vector<vjm::SystemState> loaded, unloaded;
  bool few_states = false;
  /// The first reading in use that fails, if one does; the rest is then not to be used.
  std::optional<PredictionFailure> failure;
};

}  // namespace kinetostat::calibration
