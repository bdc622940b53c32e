// The papers' own iterations for the loaded equilibrium, kept as named methods beside Newton's.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::vjm {

struct FixedPointOptions {
  int max_iterations = 100;  // of either loop, per load step
  double tolerance = 1e-11;  // of the last change, relative to the reach
  int load_steps = 1;        // values of alpha on the way from 0 to 1 (MMT11 section 4.1)
};

struct FixedPoint {
  bool converged = false;
  std::string reason;      // empty when converged
  double reached = 0;      // share of the load or displacement at the last convergence, 0..1
  spatial::Pose platform;  // in base axes
  spatial::Wrench wrench;  // on the platform, at its reference point there, base axes
  std::vector<Eigen::VectorXd> coordinates;  // of every chain
  /// Changes of the last load step: of the chains' coordinates at a given pose, of the pose under a
  /// given load; scaled by the reach.
  std::vector<double> changes;
  int iterations = 0;  // solutions of eq. 10, all chains together counting as one
};

/// MMT11 eq. 10: with the Jacobians of the last configuration, solves the linear equations for F, q
/// and theta, again and again. Its rate of convergence is the ratio of the load to a critical load:
/// it diverges where Newton's method does not. (The paper's eq. 10 leaves out - J_theta theta_0 on
/// the right, without which preloads are lost; here it is there.)
///
/// Both functions throw std::invalid_argument for what the papers do not treat: inner bodies,
/// weight, loads at nodes, stops, and chains with fewer than six independent springs and passive
/// joints.
FixedPoint fixed_point_at_pose(const Manipulator& manipulator, const Posture& posture,
                               const spatial::Pose& pose, const FixedPointOptions& options = {});

/// MMT11 eq. 11 and NONPERF eq. 21: t <- t + K_c^-1 (F - F(t)), with the loaded stiffness K_c at t
/// and eq. 10 inside.
FixedPoint fixed_point_under_load(const Manipulator& manipulator, const Posture& posture,
                                  const Load& load, const FixedPointOptions& options = {});

}  // namespace kinetostat::vjm
