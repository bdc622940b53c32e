// The options that give many poses to commands: a grid, or a path from a file.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/vjm/workspace/workspace_map.h"

namespace kinetostat::apps {

/// Poses of the platform in order, each with what acts there.
struct PoseList {
  std::vector<vjm::TargetPose> poses;
  /// Grid: numbers of points along x, y, z, rx, ry, rz; the last varies fastest. Path: the number
  /// of rows and ones.
  std::array<std::size_t, 6> shape{1, 1, 1, 1, 1, 1};
};

/// Names of the six coordinates of a pose, and the six of a wrench, as columns and in --grid.
extern const std::array<std::string, 6> pose_columns;    // x y z rx ry rz
extern const std::array<std::string, 6> wrench_columns;  // fx fy fz mx my mz

/// "x=-70:120:20,y=0,z=0:100:5": from, to and number of points, or one value; coordinates that are
/// not named are 0. Throws UsageError.
PoseList read_grid(const std::string& grid, const vjm::Robot& robot, const vjm::Load& load);

/// A CSV file with columns x, y, z, rx, ry, rz (rotation vector) and, for loads of each pose, fx,
/// fy, fz, mx, my, mz; those left out are 0. Columns are in the units of the robot file, or in one
/// of their own: "x [m]". Throws common::InputError; UsageError when both the file and `load` have
/// a wrench.
PoseList read_path(const std::string& file, const vjm::Robot& robot, const vjm::Load& load);

}  // namespace kinetostat::apps
