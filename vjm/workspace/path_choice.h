// The free motions of a path, chosen for an index of stiffness: the turn of a tool about its own
// axis, the joints of a redundant robot, and where the robot stands.
#pragma once

#include <limits>
#include <optional>
#include <string>
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

/// A joint that the pose leaves free, as in an arm of seven joints: it is held at each of some
/// values, and the other joints lead to the pose.
struct FreeJoint {
  std::string name;         // "chain.joint"
  double from = 0, to = 0;  // [m or rad]
  int steps = 37;           // values that are tried, ends included
  /// From one pose of the path to the next [m or rad].
  double largest_change = std::numeric_limits<double>::infinity();
};

/// What is free along a path.
struct PathFreedom {
  std::optional<FreeTurn> turn = {};
  std::vector<FreeJoint> joints = {};
  /// Poses of the base in the axes in which the path is given.
  std::vector<spatial::Pose> placements = {spatial::Pose()};
};

struct PathChoice {
  std::vector<TargetPose> poses;            // with what was chosen
  std::vector<double> turns;                // [rad], one a pose; empty without a free turn
  std::vector<std::vector<double>> joints;  // [m or rad], of each free joint one a pose
  std::size_t placement = 0;                // number of that of the robot's base
  double worst = 0;  // value of the index at the worst pose; NaN: some pose has none
};

/// Whether more of an index is better: not of a deflection, a rotation or a condition.
bool is_more_better(MapIndex::Kind kind);

/// A pose of a path with the platform turned, or seen from a base that stands elsewhere. What acts
/// on it stays where it is.
TargetPose turned(const TargetPose& pose, const spatial::Vector3& axis, double angle);
TargetPose seen_from(const TargetPose& pose, const spatial::Pose& base);

/// How many combinations of turn and joints are tried at each pose.
double candidates_per_pose(const PathFreedom& freedom);

/// The turns, the values of joints and the placement with which the worst pose of the path has the
/// best index; among them those with the best mean logarithm. All values on the grids are tried,
/// and with each turn the values at which the joints stand in posture_holding() the pose alone,
/// where they lie within the tried range: by dynamic programming along the path, first of the worst
/// value, then of the sum, so that no better path on the grid exists, and none is worse than the
/// given one as far as that is on the grid. Poses that are not reached, or beyond the range of a
/// drive, count as worst of all; where there is no way without, it has as few of them as can be.
/// Throws std::invalid_argument without a placement or a pose, and for an unknown joint;
/// common::Cancelled.
PathChoice best_path(const Manipulator& manipulator, const std::vector<TargetPose>& targets,
                     const MapIndex& index, const PathFreedom& freedom, int threads,
                     common::Progress& progress);

/// The change of one joint from a pose of a path to the next.
struct JointStep {
  std::string joint;     // "chain.joint"; empty: none turns
  double change = 0;     // [rad], as against whole turns
  std::size_t pose = 0;  // that it leads to
};

/// The largest change of a turning actuated joint along a path: near half a turn where the robot
/// goes over from one of several postures for a pose to another. Poses that are not reached are
/// left out.
JointStep largest_turn(const Manipulator& manipulator, const std::vector<TargetPose>& path);

}  // namespace kinetostat::vjm
