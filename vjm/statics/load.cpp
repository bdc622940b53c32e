#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::vjm {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector6;

Vector6 Load::at_reference_point(const Pose& platform) const {
  Vector6 wrench;
  wrench << force, moment + (platform.rotation() * point_on_platform).cross(force);
  return wrench;
}

Matrix6 Load::derivative(const Pose& platform) const {
  // d((dphi x r) x f) with r = R * point_on_platform
  Matrix6 d = Matrix6::Zero();
  d.bottomRightCorner<3, 3>() =
      spatial::skew(force) * spatial::skew(platform.rotation() * point_on_platform);
  return d;
}

Load Load::scaled(double factor) const {
  Load load = *this;
  load.force *= factor;
  load.moment *= factor;
  load.gravity *= factor;
  for (NodeLoad& node : load.nodes) {
    node.force *= factor;
    node.moment *= factor;
  }
  return load;
}

}  // namespace kinetostat::vjm
