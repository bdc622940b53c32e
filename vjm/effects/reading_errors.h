// How readings differ from what the manipulator itself does: the load that really acts, and the
// pose that the instrument shows.
#pragma once

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

/// Additive, so that effects on readings compose in any order. None by default. What is of the
/// wrench is in the axes of the load cell (Load::cell).
struct ReadingErrors {
  double wrench_gain = 1;                                       // actual wrench over the stated one
  spatial::Vector3 wrench_rotation = spatial::Vector3::Zero();  // of its axes [rad]
  /// What a load cell does not read: [force [N]; moment [N m]], about the stated point, wherever it
  /// reads a load at all; and by how much more than in proportion the load grows that acts, per
  /// square of the force [1/N^2] and of the moment [1/(N m)^2] that are read.
  spatial::Vector6 wrench_zero = spatial::Vector6::Zero();
  Eigen::Vector2d wrench_curvature = Eigen::Vector2d::Zero();
  /// The same as the zero, but whatever the load cell reads: of a hook that hangs on.
  spatial::Vector6 wrench_beside = spatial::Vector6::Zero();
  /// Share by which each of its six numbers is read too small.
  spatial::Vector6 wrench_channels = spatial::Vector6::Zero();
  spatial::Vector3 wrench_point = spatial::Vector3::Zero();  // from the stated one, platform [m]
  spatial::Vector6 sensor = spatial::Vector6::Zero();  // displacement of all that is read [m; rad]
  double sensor_scale = 0;  // of positions, less one: from the origin of the base
  spatial::Vector3 sensor_axes = spatial::Vector3::Zero();  // the same of each coordinate
  spatial::Vector3 target = spatial::Vector3::Zero();  // what is read on the platform, its axes [m]

  /// All zero: the start of a derivative.
  static ReadingErrors tangent();
  ReadingErrors& operator+=(const ReadingErrors& tangent);
  bool is_none() const;

  /// The load that acts where `stated` is written down.
  Load actual(const Load& stated) const;
  /// How that changes with what is stated by such a wrench [force; moment about the same point].
  Load actual_change(const Load& stated, const spatial::Vector6& change) const;
  /// Derivative of its wrench [force; moment] at the platform's reference point.
  spatial::Vector6 wrench_derivative(const Load& stated, const spatial::Pose& platform,
                                     const ReadingErrors& tangent) const;

  /// The pose that is read: [exp(sensor rotation), sensor translation] * platform * target, its
  /// position first times scale().
  spatial::Pose observed(const spatial::Pose& platform) const;
  /// Change [translation; rotation increment] of the pose that is read with such a change of the
  /// platform's, and with the errors at a given platform.
  spatial::Vector6 observed_motion(const spatial::Pose& platform,
                                   const spatial::Vector6& motion) const;
  spatial::Vector6 observed_derivative(const spatial::Pose& platform,
                                       const ReadingErrors& tangent) const;

 private:
  bool reads_load() const;  // as it acts
  bool reads_pose() const;  // of the platform as it stands
  spatial::Vector3 scale() const {
    return spatial::Vector3::Constant(1 + sensor_scale) + sensor_axes;
  }
  /// What acts more than is stated, of a load cell [force; moment].
  static spatial::Vector6 from_cell(const Load& stated, const ReadingErrors& of);
};

}  // namespace kinetostat::vjm
