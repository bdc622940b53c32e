// Paths of equilibria: force against deflection, past limit points and through bifurcations.
#pragma once

#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/continuation/path_result.h"

namespace kinetostat::vjm {

/// Follows equilibria from parameter 0 by pseudo-arclength continuation (Keller), the exact
/// Hessian in each Newton step. Critical points are where the inertia of the reduced Hessian
/// (MMT11 eq. 23) changes or the parameter turns back, and are located there. Branches leave
/// bifurcations along the null space of the equations' derivative, without perturbing the model;
/// each is followed once. A branch that meets no other is not found. `posture` is where the springs
/// are relaxed.
Path trace(const Manipulator& manipulator, const Posture& posture, const PathTask& task,
           const PathOptions& options, common::Progress& progress);

}  // namespace kinetostat::vjm
