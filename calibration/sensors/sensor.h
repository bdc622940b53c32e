// Sensors: what they look at, and what they see of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/effects/watch.h"

namespace kinetostat::calibration {

enum class SensorKind {
  pose,      // of one frame seen from another: position, rotation, a dial gauge
  tilt,      // rotation of a frame about its own axes, against the vertical
  distance,  // between the origins of two frames
  joint,     // coordinate of a joint
  load,      // force or moment that the load cell reads, where the displacement is set
  torque     // that the drive of a joint exerts: a force where it slides
};

/// By default the platform, as Campaign::observation has it, in the columns dx ... rz.
struct Sensor {
  std::string name = {};
  SensorKind kind = SensorKind::pose;
  std::size_t frame = 0, from = 0;  // in Watch::frames
  bool own_axes = false;  // differences in the axes that `frame` has without load, not in `from`'s
  /// Its readings are in the frame of the instrument, which sessions may have to estimate.
  bool by_instrument = true;
  /// What it looks at sits elsewhere on what carries it, nobody knows where.
  bool target_estimated = false;
  std::size_t joint = 0;                  // in Watch::joints
  std::optional<std::size_t> minus = {};  // sensor of the same axes that is taken off, no platform

  bool is_platform() const { return name.empty(); }
};

/// What a sensor sees at one state: a pose; numbers stand in its position, one an axis.
struct Seen {
  spatial::Pose pose;
  /// [translation; rotation increment] with the parameters, and with the stated wrench.
  Eigen::Matrix<double, 6, Eigen::Dynamic> motion = {}, by_wrench = {};
};

/// What a sensor other than the platform's sees. `up`: vertical, base axes. Derivatives as far as
/// the watch has them. A tilt about an axis that is vertical is NaN.
Seen seen_by(const Sensor& sensor, const vjm::Watched& watched, const vjm::Watch& watch,
             const spatial::Vector3& up);

/// Whether an axis (0: x) of a tilt sensor is within a milliradian of the vertical `up`, base axes:
/// what it would read is undetermined then.
bool is_blind(const Sensor& tilt, Eigen::Index axis, const vjm::Watched& watched,
              const spatial::Vector3& up);

}  // namespace kinetostat::calibration
