// An equilibrium as numbers whose uncertainties are wanted.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "kinetostat/vjm/statics/equilibrium_result.h"

namespace kinetostat::vjm {

/// Places of numbers in deflection_numbers().
struct DeflectionNumbers {
  static constexpr Eigen::Index moved = 0;         // length of the translation [m]
  static constexpr Eigen::Index turned = 1;        // of the rotation vector [rad]
  static constexpr Eigen::Index displacement = 2;  // 6: translation, rotation vector
  static constexpr Eigen::Index force = 8;         // on the platform, size [N]
  static constexpr Eigen::Index moment = 9;        // [N m]
  static constexpr Eigen::Index wrench = 10;       // 6: force, moment at the reference point
  static constexpr Eigen::Index count = 16;
};

/// Displacement and wrench of the platform, base axes. None where no equilibrium was found.
std::optional<Eigen::VectorXd> deflection_numbers(const Equilibrium& equilibrium);

}  // namespace kinetostat::vjm
