// Paths of equilibria: force against deflection, past limit points and through bifurcations.
#pragma once

#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/continuation/path_result.h"

namespace kinetostat::vjm {

/// Load and displacement along a path: at parameter p the loads are p times `growing`, and a
/// platform that is held stands p times `displacement` away from where the posture has it. Gravity
/// and the constant loads act all along.
struct PathTask {
  bool platform_held = true;
  /// [translation m; rotation vector rad] at p = 1, base axes; of a held platform.
  spatial::Vector6 displacement = spatial::Vector6::Zero();
  Load growing = {};  // on nodes and, when it is free, on the platform
  std::vector<NodeLoad> constant = {};

  Load load(double parameter) const;
};

struct PathOptions {
  double lowest = -1, highest = 1;  // range of the parameter; a branch ends where it leaves it
  int points = 50;                  // at least so many on the way from 0 to 1
  int most_points = 2000;           // on one branch
  bool branches = false;            // follow what leaves at bifurcations, too
  int most_branches = 50;
  bool until_critical = false;  // stop at the first critical point
};

/// Force against deflection in the direction of a task: of its displacement or, when the platform
/// is free, of its growing force (else of its rotation or moment).
struct Along {
  double deflection = 0;            // [m or rad]
  double force = 0;                 // on the platform, in that direction [N or N m]
  std::optional<double> stiffness;  // slope of the path; none where it is vertical, or has a corner
};

/// A point of a path.
struct PathPoint {
  double parameter = 0;
  Equilibrium equilibrium;  // with K_c, K_q and K_theta (MMT11 eq. 29-30)
  /// Elastic energy less the work of dead forces and weights [J]; none when moments act.
  std::optional<double> potential;
  std::optional<Along> along;  // none for a task that only loads nodes of chains

  /// Stability of what the task leaves free: with the platform held, or under the dead load.
  const Stability& stability(const PathTask& task) const {
    return task.platform_held ? equilibrium.held : equilibrium.free;
  }
};

enum class CriticalKind {
  limit_point,  // the parameter turns back
  bifurcation,  // other branches pass through
  contact,      // stability changes where the tangent of a law has a jump: a joint meets a stop
};

/// Where stability changes, or branches meet.
struct CriticalPoint {
  CriticalKind kind = CriticalKind::bifurcation;
  std::size_t branch = 0;  // on which it was found
  std::size_t after = 0;   // it lies between this point of the branch and the next
  PathPoint point;
  int multiplicity = 1;                         // motions that become free
  double uncertainty = 0;                       // of the parameter, from locating the point
  int unstable_before = 0, unstable_after = 0;  // directions
};

enum class BranchEnd {
  range,     // the parameter left the range
  target,    // the parameter came to 1, the highest allowed
  junction,  // at a bifurcation that is already known
  joined,    // on a branch that was followed before, which it would only repeat
  closed,    // back on itself: a loop. Full turns of joints without springs and laws do not count
  free,      // more than one motion costs nothing: the equilibria form a surface, not a curve
  locked,    // the force grows without displacement
  limit,     // most_points
  critical,  // at the first critical point, which was all that was asked for
  lost       // the equations could not be solved further, however small the step
};

struct Branch {
  std::optional<std::size_t> from;  // critical point where it leaves another branch
  std::optional<std::size_t> to;    // where it meets one, for BranchEnd::junction
  std::optional<std::size_t> onto;  // branch, for BranchEnd::joined
  std::vector<PathPoint> points;
  BranchEnd end = BranchEnd::lost;
  std::string reason;  // in words, for `lost`
};

struct TargetPoint {
  std::size_t branch = 0;
  PathPoint point;
};

struct Path {
  EquilibriumStatus status = EquilibriumStatus::converged;  // of the first equilibrium
  std::string reason;
  std::vector<Branch> branches;  // the first starts at parameter 0
  std::vector<CriticalPoint> critical;
  /// All equilibria that were met at parameter 1, each once, stable ones first, then by potential.
  std::vector<TargetPoint> at_target;
  /// Directions that leave bifurcations and were not tried for PathOptions::most_branches.
  std::size_t not_tried = 0;
};

/// The equilibrium at a parameter, sought from the relaxed posture and not along the path.
Equilibrium equilibrium_at(const Manipulator& manipulator, const Posture& posture,
                           const PathTask& task, double parameter);

/// Whether Along speaks of a rotation and a moment.
bool turns(const PathTask& task);

/// Follows equilibria from parameter 0 by pseudo-arclength continuation (Keller), the exact
/// Hessian in each Newton step. Critical points are where the inertia of the reduced Hessian
/// (MMT11 eq. 23) changes or the parameter turns back, and are located there. Branches leave
/// bifurcations along the null space of the equations' derivative, without perturbing the model;
/// each is followed once. A branch that meets no other is not found. `posture` is where the springs
/// are relaxed.
Path trace(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
           const PathOptions& options, common::Progress& progress);

}  // namespace kinetostat::vjm
