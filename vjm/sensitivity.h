// How the loaded pose changes with a parameter of the model: exact derivatives of the solution.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/equilibrium.h"

namespace kinetostat::vjm {

/// A spring of a chain, as a parameter: its stiffness is multiplied as a whole.
struct SpringParameter {
  std::size_t chain = 0;
  std::string spring;
};

/// Derivatives of the platform displacement [m; rad] (base axes) at an equilibrium under `load`
/// with respect to the natural logarithm of each spring's stiffness, by implicit differentiation of
/// the equations of equilibrium: one column per parameter. Throws std::invalid_argument for an
/// unknown spring.
Eigen::Matrix<double, 6, Eigen::Dynamic> displacement_by_log_stiffness(
    const Manipulator& manipulator, const Posture& posture, const Load& load,
    const Equilibrium& equilibrium, const std::vector<SpringParameter>& parameters);

}  // namespace kinetostat::vjm
