// Readings that effects say are off by a constant, and which they may be.
#pragma once

#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/calibration/regression/predictions.h"
#include "kinetostat/vjm/effects/effect_model.h"

namespace kinetostat::calibration {

/// Whether an effect is of whole load cycles, whenever they are; else from some moment on.
bool is_of_cycles(const vjm::EffectKind& kind);

/// Of every reading. Sessions and cycles are numbered in the order of Campaign::sessions and of
/// cycles_as_run().
std::vector<vjm::ReadingMoment> moments_of(const Campaign& campaign);

/// [translation; rotation increment] of the platform in its own axes to what is read of it, one a
/// reading; empty where differences are read.
using PlatformAxes = std::vector<spatial::Matrix6>;

/// What readings show of effects that offset them (EffectKind::offsets_readings), in the components
/// that may lag (instrument_lag.h).
class ReadingOffsets {
 public:
  /// Keeps references to both.
  ReadingOffsets(const Campaign& campaign, const PlatformAxes& axes);
  /// What a component shows of each of the first six values of an effect: zero where it is not off.
  Eigen::Matrix<double, 1, 6> shown(const vjm::Effect& effect, std::size_t reading,
                                    Eigen::Index component) const;

 private:
  const Campaign& campaign_;
  const PlatformAxes& axes_;
  std::vector<vjm::ReadingMoment> moments_;
};

/// Adds to predictions what they are off, with derivatives by `parameters` where the predictions
/// have them.
void add_offsets(const Campaign& campaign, const PlatformAxes& axes,
                 const std::vector<vjm::Effect>& effects,
                 const std::vector<vjm::ModelParameter>& parameters, Predictions& predictions);

/// The effect at all readings that it may name, in the order of time: from a reading of a session
/// on whose readings all have a time, with three at least before and after; each of three or more
/// load cycles with three readings or more; in differences also from a reading within a cycle to
/// its end, with one before it and three from it on. Only readings in use count. What may turn
/// along with the platform does so in as many more where the platform turns by 0.02 rad at least.
/// Empty where there are none.
std::vector<vjm::Effect> placements(const vjm::Effect& effect, const Campaign& campaign,
                                    const PlatformAxes& axes);

}  // namespace kinetostat::calibration
