// The free motions of a path, chosen for an index of stiffness: the turn of a tool about its own
// axis, and where the robot stands.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "kinetostat/vjm/workspace/workspace_map.h"

namespace kinetostat::vjm {

/// A turn of the platform about an axis of its own through its origin, which the work leaves free.
struct FreeTurn {
  spatial::Vector3 axis = spatial::Vector3::UnitZ();  // unit vector, platform axes
  double from = 0, to = 0;                            // [rad], as against the given pose
  int steps = 72;                                     // values that are tried, ends included
  /// From one pose of the path to the next [rad].
  double largest_change = std::numeric_limits<double>::infinity();
};

struct PathChoice {
  std::vector<TargetPose> poses;  // with the turns and the placement that were chosen
  std::vector<double> turns;      // [rad], one a pose; empty without a free turn
  std::size_t placement = 0;      // number of that of the robot's base
  double worst = 0;               // value of the index at the worst pose; NaN: some pose has none
};

/// Whether more of an index is better: not of a deflection, a rotation or a condition.
bool is_more_better(MapIndex::Kind kind);

/// A pose of a path with the platform turned, or seen from a base that stands elsewhere. What acts
/// on it stays where it is.
TargetPose turned(const TargetPose& pose, const spatial::Vector3& axis, double angle);
TargetPose seen_from(const TargetPose& pose, const spatial::Pose& base);

/// The turns and the placement (one of `placements`, poses of the base in the axes in which the
/// path is given; at least one) with which the worst pose of the path has the best index; among
/// them those with the best mean logarithm. All values on the grids are tried: by dynamic
/// programming along the path, first of the worst value, then of the sum, so that no better path
/// on the grid exists. Poses that are not reached, or beyond the range of a drive, count as worst
/// of all; where there is no way without, it has as few of them as can be. Throws
/// std::invalid_argument without a placement; common::Cancelled.
PathChoice best_path(const Manipulator& manipulator, const std::vector<TargetPose>& targets,
                     const MapIndex& index, const std::optional<FreeTurn>& turn,
                     const std::vector<spatial::Pose>& placements, int threads,
                     common::Progress& progress);

}  // namespace kinetostat::vjm
