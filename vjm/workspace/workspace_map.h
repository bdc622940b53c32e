// Stiffness indices over many poses: grids and paths.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/workspace/map_checkpoint.h"
#include "kinetostat/vjm/workspace/pose_list.h"

namespace kinetostat::vjm {

/// One figure of merit of a pose, in SI units.
struct MapIndex {
  enum class Kind {
    stiffness,            // force over displacement along `direction`, pure force [N/m]
    rotational,           // moment over rotation about `direction`, pure moment [N m/rad]
    weakest_translation,  // smallest eigen-stiffness under pure forces [N/m]
    weakest_rotation,     // smallest eigen-stiffness under pure moments [N m/rad]
    weakest,              // smallest eigenvalue with rotations times `length` [N/m]
    condition,            // largest over smallest eigenvalue, scaled likewise
    deflection,           // of the reference point under load and weight [m]
    rotation,             // of the platform under load and weight [rad]
    first_frequency,      // of the natural modes of the relaxed posture [Hz]
    critical_force,       // dead force along `direction` at which the platform gives way [N]
  };
  Kind kind = Kind::weakest_translation;
  spatial::Vector3 direction = spatial::Vector3::UnitX();  // unit vector, base axes
  double length = 1;                                       // [m]
  double up_to = 1;                                        // [N] the critical force is sought
};

spatial::Dimension dimension_of(MapIndex::Kind kind);

/// "reached", "free motion", "unstable", "no equilibrium", "unreachable".
std::string to_string(MapState state);

/// One pose. Stiffness is the tangent at the state in which the manipulator stands: under the load,
/// weight, preloads and geometric errors where there are any, else that of the relaxed posture. All
/// forces and moments are taken at the platform's reference point.
///
/// A critical force grows from nothing at the reference point beside the weight and the forces on
/// nodes, until the equilibrium under it is no longer stable: the first critical point of trace().
/// Infinite when none is met on the way; NaN when the path is lost. Throws std::invalid_argument
/// when it is asked for beside a wrench on the platform.
///
/// `finer` is the same robot with its beams in two and in four times the segments, or nothing when
/// it has no beams. One spring does not feel its own beam buckle: stability is judged by the first
/// of them, and critical forces are Richardson's estimate for the distributed beams, from the given
/// segments and their double (from two and four times them where the given ones show none).
MapPoint map_point(const Manipulator& manipulator, const TargetPose& target,
                   const std::vector<MapIndex>& indices,
                   const std::vector<Manipulator>& finer = {});

/// All poses, on several threads; the result does not depend on their number. Throws
/// common::Cancelled, having saved the checkpoint, and common::InputError for a checkpoint of
/// another map or a damaged one.
std::vector<MapPoint> workspace_map(const Manipulator& manipulator,
                                    const std::vector<TargetPose>& targets,
                                    const std::vector<MapIndex>& indices, int threads,
                                    common::Progress& progress, MapCheckpoint* checkpoint = nullptr,
                                    const std::vector<Manipulator>& finer = {});

/// Range of one index over the poses that have a finite value.
struct MapRange {
  std::size_t count = 0;
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -std::numeric_limits<double>::infinity();
  double mean = 0;
  std::size_t smallest_at = 0, largest_at = 0;  // numbers of poses
};
MapRange range_of(const std::vector<MapPoint>& points, std::size_t index);

}  // namespace kinetostat::vjm
