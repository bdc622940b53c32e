// External loads on a manipulator.
#pragma once

#include <compare>
#include <vector>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::vjm {

/// A wrench constant in base axes at a node of a chain: force [N], moment [N m].
struct NodeLoad {
  std::size_t chain = 0;
  std::size_t node = 0;
  spatial::Vector3 force = spatial::Vector3::Zero();
  spatial::Vector3 moment = spatial::Vector3::Zero();
};

/// A torque (a force where it slides) between the links before and behind a joint, positive along
/// its coordinate [N m or N]; it turns with the joint.
struct JointForce {
  std::size_t chain = 0;
  Eigen::Index coordinate = 0;
  double force = 0;
  /// Unit twist of the joint without load, base axes: by it loads are compared; the equations take
  /// that of the joint itself.
  spatial::Vector6 direction = spatial::Vector6::Zero();
};

/// Dead loads: force and moment constant in base axes, at a point fixed to the platform and at
/// nodes of the chains; forces in joints; and the share of gravity that acts (1, but for the steps
/// on the way to it).
struct Load {
  spatial::Vector3 force = spatial::Vector3::Zero();              // [N]
  spatial::Vector3 moment = spatial::Vector3::Zero();             // about `point` [N m]
  spatial::Vector3 point_on_platform = spatial::Vector3::Zero();  // [m], platform axes
  std::vector<NodeLoad> nodes = {};
  std::vector<JointForce> joints = {};
  double gravity = 1;
  /// Axes, as columns in base axes, of the load cell that read `force` and `moment`: its errors go
  /// by them.
  spatial::Matrix3 cell = spatial::Matrix3::Identity();

  /// [force; moment about the platform's reference point] of the platform's part.
  spatial::Vector6 at_reference_point(const spatial::Pose& platform) const;
  /// Derivative of that with respect to a displacement of the platform.
  spatial::Matrix6 derivative(const spatial::Pose& platform) const;
  Load scaled(double factor) const;
};

/// Some total order of loads in which only the same ones are equal. Requires finite numbers.
std::strong_ordering order_of(const Load& a, const Load& b);

}  // namespace kinetostat::vjm
