// Commands that bring the loaded, imperfect manipulator where it was meant to be.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/workspace/pose_list.h"

namespace kinetostat::vjm {

/// Which of x, y, z, rx, ry, rz (base axes) must be met.
using Components = std::array<bool, 6>;

struct CompensationOptions {
  /// By default all six where the actuators move the platform in six independent ways, else the
  /// translations.
  std::optional<Components> components = {};
  double tolerance = 1e-11;  // of the last correction of the commands, relative to the reach
  int max_iterations = 40;
  EquilibriumOptions equilibrium = {};
};

enum class CompensationStatus {
  converged,
  unreachable,     // the nominal manipulator does not reach the target, or the corrected commands
  no_equilibrium,  // the load cannot be carried there, or only in an unstable way
  not_converged,
};

struct Compensation {
  CompensationStatus status = CompensationStatus::not_converged;
  std::string reason;       // empty when converged
  Components components{};  // that were to be met
  Posture nominal;          // commands for the target itself (nominal inverse kinematics)
  Posture corrected;        // its platform is the modified target t0(F) of NONPERF eq. 22
  /// Pose of the platform in equilibrium minus the target [m; rad], base axes: with the nominal
  /// commands, and with the corrected ones, both on the full nonlinear equations.
  spatial::Vector6 error = spatial::Vector6::Zero();
  spatial::Vector6 residual = spatial::Vector6::Zero();
  int iterations = 0;
};

/// Solves NONPERF eq. 22 for the commands of the actuators: errors by compliance, weight, assembly
/// and geometry together. The paper's iteration (eq. 23) shifts the target in all six components by
/// the error that is left; here the commands are corrected, so that manipulators of lower mobility
/// are served too, with Broyden's update of the nominal Jacobian. The part that the actuators
/// cannot reach (the tilt of a translational robot) stays in `residual`.
Compensation compensate(const Manipulator& manipulator, const TargetPose& target,
                        const CompensationOptions& options = {});

}  // namespace kinetostat::vjm
