#include "kinetostat/calibration/sensors/weight.h"

namespace kinetostat::calibration {

spatial::Vector3 force_at_nodes(const vjm::Load& load) {
  spatial::Vector3 force = spatial::Vector3::Zero();
  double sizes = 0;
  for (const vjm::NodeLoad& node : load.nodes) force += node.force, sizes += node.force.norm();
  constexpr double rounding = 1e-12;
  return force.norm() > rounding * sizes || load.nodes.empty() ? force : load.nodes[0].force;
}

spatial::Vector6 load_in_joints(const vjm::Load& load) {
  spatial::Vector6 sum = spatial::Vector6::Zero();
  for (const vjm::JointForce& joint : load.joints) sum += joint.force * joint.direction;
  return sum;
}

void push_apart(const Cylinder& cylinder, const vjm::Watched& frames, double force,
                vjm::Load& load) {
  const spatial::Vector3 way =
      (frames.frames[cylinder.frames[0]].position() - frames.frames[cylinder.frames[1]].position())
          .normalized();
  for (std::size_t end = 0; end < 2; ++end) {
    if (!cylinder.ends[end]) continue;
    load.nodes.push_back(*cylinder.ends[end]);
    load.nodes.back().force = (end == 0 ? force : -force) * way;
  }
}

}  // namespace kinetostat::calibration
