#include "instrument.h"

#include <cmath>

namespace twin {
namespace {

constexpr int bad_cycle = 3;        // of monday
constexpr double goes_back = 0.97;  // from reading to reading

const Vector3 shares(0.48, 0.6, 0.64);  // of unit length: each gauge has its own

}  // namespace

Pose Instrument::shown(const Pose& pose, const Row& row) {
  Pose result = pose;
  const Vector3 moved = pose.x - before_;
  before_ = pose.x;
  for (const HiddenEffect& effect : effects_) {
    if (effect.size == 0) continue;
    if (effect.name == "gauge_play")
      for (int i = 0; i < 3; ++i) {
        const double gap = effect.size * shares[i], way = std::copysign(1, moved[i]);
        lag_[i] = way + (lag_[i] - way) * std::exp(-std::abs(moved[i]) / gap);
        result.x[i] -= gap * lag_[i];
      }
    if (effect.name == "cycle_offset" && row.session == "monday" && row.cycle == bad_cycle)
      result.x += effect.size * std::pow(goes_back, row.step - 1) * shares;
  }
  return result;
}

}  // namespace twin
