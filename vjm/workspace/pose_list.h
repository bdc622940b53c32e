// Poses of the platform with what acts there: a grid or a path.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

/// Where the platform is sent with relaxed links, and what acts on it there.
struct TargetPose {
  spatial::Pose platform;
  Load load = {};
  /// Joints ("chain.joint") of a redundant robot that keep these values [m or rad] there.
  std::map<std::string, double> held = {};
  bool is_by_joints = false;  // those held alone lead there, all others keep their home values
};

/// Throws std::invalid_argument for a joint that is unknown.
PostureResult posture_to(const Manipulator& manipulator, const TargetPose& target);

/// Target poses in order, or every n-th of them.
struct PoseList {
  std::vector<TargetPose> poses;
  /// Grid: numbers of points along x, y, z, rx, ry, rz; the last varies fastest. Path, or a part of
  /// either: the number of poses and ones.
  std::array<std::size_t, 6> shape{1, 1, 1, 1, 1, 1};
  std::size_t whole = 0;                  // how many there are, those of other parts among them
  std::vector<std::size_t> numbers = {};  // of the poses in the whole list, where they are a part
  bool has_wrench = false;                // whether one acts at any pose of the whole list
  std::vector<std::string> notes = {};    // what was assumed of the poses, in words
};

/// Names of the six coordinates of a pose (position and rotation vector), and of a wrench.
inline constexpr std::array<const char*, 6> pose_columns{"x", "y", "z", "rx", "ry", "rz"};
inline constexpr std::array<const char*, 6> wrench_columns{"fx", "fy", "fz", "mx", "my", "mz"};

}  // namespace kinetostat::vjm
