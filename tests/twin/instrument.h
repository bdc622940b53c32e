// What an instrument makes of a pose that it looks at: it may remember what it showed before.
#pragma once

#include <vector>

#include "hidden_effect.h"

namespace twin {

/// An instrument in one load cycle.
class Instrument {
 public:
  Instrument() = default;
  /// `start`: the pose of the unloaded state, with which the cycle starts.
  Instrument(std::vector<HiddenEffect> effects, const Pose& start)
      : effects_(std::move(effects)), before_(start.x) {}

  /// What is read of a pose, the next of the cycle. Gauges with play (`gauge_play`) lag behind by
  /// Dahl's law, dz = (sgn du - z) |du| / gap, which has no corner; what stands on a base that
  /// somebody has leaned on (`cycle_offset`: before one cycle of monday) is off and goes back by
  /// 3 % from reading to reading.
  Pose shown(const Pose& pose, const Row& row);

 private:
  std::vector<HiddenEffect> effects_;
  Vector3 before_ = Vector3::Zero(), lag_ = Vector3::Zero();  // z, from -1 to 1
};

}  // namespace twin
