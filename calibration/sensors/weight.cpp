#include "kinetostat/calibration/sensors/weight.h"

namespace kinetostat::calibration {

spatial::Vector3 force_at_nodes(const vjm::Load& load) {
  spatial::Vector3 force = spatial::Vector3::Zero();
  for (const vjm::NodeLoad& node : load.nodes) force += node.force;
  return force;
}

}  // namespace kinetostat::calibration
