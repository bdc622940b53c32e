// The stiffness of a robot as numbers whose uncertainties are wanted.
#pragma once

#include "kinetostat/vjm/uncertainty/propagation.h"

namespace kinetostat::vjm {

/// Places of numbers in stiffness_numbers().
struct StiffnessNumbers {
  static constexpr Eigen::Index along = 0;       // compliance along a direction [m/N]
  static constexpr Eigen::Index compliance = 1;  // the 36 of the 6x6 [SI], row by row
  static constexpr Eigen::Index stiffness = 37;  // the same of its inverse
  static constexpr Eigen::Index count = 73;
};

/// Of the unloaded robot in a posture, at the reference point, base axes; `direction`: a unit
/// vector. The stiffness is 0 where the robot is rigid. None where a motion of the platform is
/// free.
std::optional<Eigen::VectorXd> stiffness_numbers(const Robot& robot, const Posture& posture,
                                                 const spatial::Vector3& direction);

}  // namespace kinetostat::vjm
