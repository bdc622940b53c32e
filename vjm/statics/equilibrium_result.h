// An equilibrium of a manipulator: what is asked of the search, and what is found.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/vjm/statics/stability.h"

namespace kinetostat::vjm {

enum class EquilibriumStatus {
  converged,
  rigid,          // pose asked of a manipulator that cannot follow it in some direction
  unsupported,    // the load has work to do on a free motion: nothing resists it
  not_converged,  // the path of equilibria ends (limit point), or could not be followed
};

struct EquilibriumOptions {
  int max_kinks = 12;        // corrections that may cross a bend of a law untested
  int max_iterations = 30;   // Newton corrections per load step
  int max_steps = 200;       // load steps (the whole load is tried first)
  double tolerance = 1e-11;  // of the last correction, relative to the reach of the robot
};

/// One chain at equilibrium.
struct ChainEquilibrium {
  Eigen::VectorXd coordinates;  // all of the chain [m or rad]
  /// That the platform exerts on the chain, at the platform's reference point there, base axes.
  spatial::Wrench wrench;
  std::optional<spatial::Stiffness6> stiffness;  // loaded K_c (MMT11 eq. 30); none when rigid
  /// Change of all coordinates with the platform's displacement, K_q and K_theta of MMT11 eq. 29.
  Eigen::MatrixXd motion;
  Stability held;  // of the chain with its end held (MMT11 eq. 23)
};

struct Equilibrium {
  EquilibriumStatus status = EquilibriumStatus::not_converged;
  std::string reason;      // empty when converged
  double reached = 0;      // share of the load or displacement that was reached, 0..1
  spatial::Pose platform;  // in base axes
  std::vector<spatial::Pose> inner_bodies;  // of the manipulator, in base axes
  spatial::Twist displacement;              // from the posture; rotation as a rotation vector
  spatial::Wrench wrench;        // on the platform, at its reference point there, base axes
  bool has_inner_loads = false;  // at nodes or in joints, beside that
  /// Tangent stiffness for a wrench that is constant in base axes; with moments it is not
  /// symmetric. None when a chain is rigid in some direction.
  std::optional<spatial::Stiffness6> stiffness;
  /// Its inverse; none when some motion is free. With rigid directions it has a rank below 6.
  std::optional<spatial::Compliance6> compliance;
  std::vector<ChainEquilibrium> chains;
  Stability held;     // every chain with the platform held
  Stability free;     // the platform under the dead load
  double energy = 0;  // elastic [J]
  int steps = 0;      // load steps
  /// Norms of the Newton corrections of the last load step, relative to the reach; quadratic.
  std::vector<double> corrections;
};

}  // namespace kinetostat::vjm
