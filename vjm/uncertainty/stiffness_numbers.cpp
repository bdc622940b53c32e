#include "kinetostat/vjm/uncertainty/stiffness_numbers.h"

#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::vjm {

std::optional<Eigen::VectorXd> stiffness_numbers(const Robot& robot, const Posture& posture,
                                                 const spatial::Vector3& direction) {
  const UnloadedStiffness unloaded = unloaded_stiffness(robot.manipulator, posture);
  if (!unloaded.compliance) return std::nullopt;
  const spatial::Matrix6& c = unloaded.compliance->matrix();
  Eigen::VectorXd numbers = Eigen::VectorXd::Zero(StiffnessNumbers::count);
  numbers[StiffnessNumbers::along] = direction.dot(c.topLeftCorner<3, 3>() * direction);
  numbers.segment<36>(StiffnessNumbers::compliance) = c.transpose().reshaped();
  if (unloaded.stiffness)
    numbers.segment<36>(StiffnessNumbers::stiffness) =
        unloaded.stiffness->matrix().transpose().reshaped();
  return numbers;
}

}  // namespace kinetostat::vjm
