// The measured point of the platform, and the measuring axes.
#pragma once

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::calibration {

/// By default the pose of the platform's reference point in the base frame.
struct Observation {
  spatial::Pose frame;  // in which displacements are given, seen from the base frame
  /// Differences are given in the axes that the platform has without load, instead.
  bool platform_axes = false;
  spatial::Vector3 target = spatial::Vector3::Zero();  // what is measured, platform axes [m]

  bool is_default() const;
  /// Pose of the target in the measuring frame, for a pose of the platform in base axes.
  spatial::Pose seen(const spatial::Pose& platform) const;
  /// [translation; rotation increment] of the platform in base axes, as measured; one a column.
  Eigen::Matrix<double, 6, Eigen::Dynamic> motion(
      const spatial::Pose& platform, const Eigen::Matrix<double, 6, Eigen::Dynamic>& motion) const;
  /// The pose of the platform in base axes of which `seen` is what is seen.
  spatial::Pose platform(const spatial::Pose& seen) const;
  /// The wrench [force; moment about the reference point], base axes, as it works on the
  /// displacement of the target: [force; moment about the target] in the measuring axes, for poses
  /// of the platform without load and under it.
  spatial::Vector6 wrench(const spatial::Pose& unloaded, const spatial::Pose& loaded,
                          const spatial::Vector6& wrench) const;
};

/// A displacement [translation; rotation vector] in the axes of the pose that it starts from, and
/// its derivatives (none: no columns), columns [translation; rotation increment] like those of that
/// pose.
void into_axes_of(const spatial::Pose& from,
                  const Eigen::Matrix<double, 6, Eigen::Dynamic>& from_derivatives,
                  spatial::Vector6& displacement,
                  Eigen::Matrix<double, 6, Eigen::Dynamic>& derivatives);

}  // namespace kinetostat::calibration
