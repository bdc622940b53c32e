// Poses of the platform with what acts there: a grid or a path.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

/// Where the platform is sent with relaxed links, and what acts on it there.
struct TargetPose {
  spatial::Pose platform;
  Load load = {};
  /// Joints ("chain.joint") of a redundant robot that keep these values [m or rad] there.
  std::map<std::string, double> held = {};
};

/// Target poses in order.
struct PoseList {
  std::vector<TargetPose> poses;
  /// Grid: numbers of points along x, y, z, rx, ry, rz; the last varies fastest. Path: the number
  /// of rows and ones.
  std::array<std::size_t, 6> shape{1, 1, 1, 1, 1, 1};
};

/// Names of the six coordinates of a pose (position and rotation vector), and of a wrench.
inline constexpr std::array<const char*, 6> pose_columns{"x", "y", "z", "rx", "ry", "rz"};
inline constexpr std::array<const char*, 6> wrench_columns{"fx", "fy", "fz", "mx", "my", "mz"};

}  // namespace kinetostat::vjm
