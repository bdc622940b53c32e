#include "kinetostat/vjm/statics/load.h"

#include <algorithm>
#include <tuple>

namespace kinetostat::vjm {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
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
  for (JointForce& joint : load.joints) joint.force *= factor;
  return load;
}

namespace {

std::strong_ordering order_of(double a, double b) {
  if (a == b) return std::strong_ordering::equal;
  return a < b ? std::strong_ordering::less : std::strong_ordering::greater;
}

std::strong_ordering order_of(const Vector3& a, const Vector3& b) {
  for (Eigen::Index k = 0; k < 3; ++k)
    if (const auto order = order_of(a[k], b[k]); order != 0) return order;
  return std::strong_ordering::equal;
}

std::strong_ordering order_of(const NodeLoad& a, const NodeLoad& b) {
  if (const auto order = std::tie(a.chain, a.node) <=> std::tie(b.chain, b.node); order != 0)
    return order;
  const auto order = order_of(a.force, b.force);
  return order != 0 ? order : order_of(a.moment, b.moment);
}

std::strong_ordering order_of(const JointForce& a, const JointForce& b) {
  const auto order = std::tie(a.chain, a.coordinate) <=> std::tie(b.chain, b.coordinate);
  return order != 0 ? order : order_of(a.force, b.force);
}

template <class Part>
std::strong_ordering order_of(const std::vector<Part>& a, const std::vector<Part>& b) {
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (const auto order = order_of(a[i], b[i]); order != 0) return order;
  return a.size() <=> b.size();
}

}  // namespace

std::strong_ordering order_of(const Load& a, const Load& b) {
  for (const auto part : {&Load::force, &Load::moment, &Load::point_on_platform})
    if (const auto order = order_of(a.*part, b.*part); order != 0) return order;
  if (const auto order = order_of(a.nodes, b.nodes); order != 0) return order;
  if (const auto order = order_of(a.joints, b.joints); order != 0) return order;
  for (Eigen::Index k = 0; k < 3; ++k)
    if (const auto order = order_of(a.cell.col(k), b.cell.col(k)); order != 0) return order;
  return order_of(a.gravity, b.gravity);
}

}  // namespace kinetostat::vjm
