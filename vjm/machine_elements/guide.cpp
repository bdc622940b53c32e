#include "kinetostat/vjm/machine_elements/guide.h"

namespace kinetostat::vjm {

spatial::Matrix6 guide_stiffness(const std::vector<Carriage>& carriages) {
  spatial::Matrix6 sum = spatial::Matrix6::Zero();
  for (const Carriage& carriage : carriages) {
    spatial::Vector6 own;
    own << 0, carriage.lateral, carriage.normal, carriage.roll, carriage.pitch, carriage.yaw;
    spatial::Matrix6 motion = spatial::Matrix6::Identity();
    motion.topRightCorner<3, 3>() = -spatial::skew(carriage.place);
    sum += motion.transpose() * own.asDiagonal() * motion;
  }
  return sum;
}

}  // namespace kinetostat::vjm
