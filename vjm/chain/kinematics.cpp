#include "kinetostat/vjm/chain/kinematics.h"

#include <cmath>

namespace kinetostat::vjm {
namespace {

using spatial::Matrix3;
using spatial::Vector3;
using spatial::Vector6;

// Turns the frame about its own axis: only the two other columns change.
void turn(Matrix3& rotation, int axis, double angle) {
  if (angle == 0) return;  // as of every relaxed spring
  const double c = std::cos(angle), s = std::sin(angle);
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  const Vector3 u = rotation.col(a), v = rotation.col(b);
  rotation.col(a) = c * u + s * v;
  rotation.col(b) = c * v - s * u;
}

// Velocity of a point that a joint moves, from the joint's twist at the end point.
Vector3 velocity_at(const Matrix6X& twists, Eigen::Index joint, const Vector3& from_end) {
  return twists.col(joint).head<3>() + twists.col(joint).tail<3>().cross(from_end);
}

}  // namespace

void evaluate(const Chain& chain, const Eigen::VectorXd& x, ChainKinematics& kinematics,
              const spatial::Pose& origin) {
  const auto joints = static_cast<Eigen::Index>(chain.joints().size());
  Matrix6X& twists = kinematics.joint_twists;
  twists.resize(6, joints);
  Matrix3 rotation = origin.rotation();
  Vector3 position = origin.position();
  kinematics.nodes.resize(chain.nodes().size());
  std::size_t placed = 0;
  const std::vector<std::size_t>& order = chain.nodes_by_joints();
  const auto place_nodes = [&](Eigen::Index joints_passed) {
    for (; placed < order.size() && chain.nodes()[order[placed]].joints == joints_passed; ++placed)
      kinematics.nodes[order[placed]] = position + rotation * chain.nodes()[order[placed]].position;
  };

  // First pass: the axis of each joint in the tail rows, its origin in the head rows.
  for (Eigen::Index j = 0; j < joints; ++j) {
    place_nodes(j);
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    if (!joint.before_is_identity) {
      position += rotation * joint.before.position();
      rotation = rotation * joint.before.rotation();
    }
    const int axis = axis_index(joint.motion);
    const double value = joint.factor * x[joint.coordinate];
    twists.col(j) << position, rotation.col(axis);
    if (is_rotation(joint.motion)) {
      turn(rotation, axis, value);
    } else {
      position += value * rotation.col(axis);
    }
  }
  place_nodes(joints);
  position += rotation * chain.tail().position();
  rotation = rotation * chain.tail().rotation();
  // Rounding in a long product leaves the rotation orthonormal to about 1e-15 per joint.
  kinematics.end = spatial::Pose(rotation, position);

  // Second pass: twists at the end point, gathered per coordinate.
  kinematics.jacobian.setZero(6, chain.size());
  kinematics.reach = 0;
  for (Eigen::Index j = 0; j < joints; ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    const Vector3 arm = position - twists.col(j).head<3>();
    const Vector3 direction = joint.factor * twists.col(j).tail<3>();
    if (is_rotation(joint.motion)) {
      twists.col(j) << direction.cross(arm), direction;
    } else {
      twists.col(j) << direction, Vector3::Zero();
    }
    kinematics.jacobian.col(joint.coordinate) += twists.col(j);
    kinematics.reach = std::max(kinematics.reach, arm.norm());
  }
}

spatial::Pose frame_behind(const Chain& chain, const Eigen::VectorXd& x, Eigen::Index joints,
                           const spatial::Pose& origin) {
  Matrix3 rotation = origin.rotation();
  Vector3 position = origin.position();
  for (Eigen::Index j = 0; j < joints; ++j) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(j)];
    position += rotation * joint.before.position();
    rotation = rotation * joint.before.rotation();
    const int axis = axis_index(joint.motion);
    const double value = joint.factor * x[joint.coordinate];
    if (is_rotation(joint.motion)) {
      turn(rotation, axis, value);
    } else {
      position += value * rotation.col(axis);
    }
  }
  return {rotation, position};
}

PointWrench at_end(const Chain& chain, const ChainKinematics& kinematics, const Vector6& wrench) {
  return {wrench, kinematics.end.position(), static_cast<Eigen::Index>(chain.joints().size())};
}

PointWrench at_node(const Chain& chain, const ChainKinematics& kinematics, std::size_t node,
                    const Vector6& wrench) {
  return {wrench, kinematics.nodes[node], chain.nodes()[node].joints};
}

void add_generalised_force(const Chain& chain, const ChainKinematics& kinematics,
                           const PointWrench& load, Eigen::VectorXd& force) {
  const Vector3 from_end = load.point - kinematics.end.position();
  for (Eigen::Index j = 0; j < load.joints; ++j)
    force[chain.joints()[static_cast<std::size_t>(j)].coordinate] +=
        load.wrench.head<3>().dot(velocity_at(kinematics.joint_twists, j, from_end)) +
        load.wrench.tail<3>().dot(kinematics.joint_twists.col(j).tail<3>());
}

void add_wrench_hessian(const Chain& chain, const ChainKinematics& kinematics,
                        const std::vector<PointWrench>& loads, Eigen::MatrixXd& hessian) {
  const Matrix6X& twists = kinematics.joint_twists;
  const auto& joints = chain.joints();
  // Sums over the loads behind a joint: forces, moments, and sum of (r f' - r.f I), which makes
  // (w x r) x f of a rotation w.
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  Matrix3 turning = Matrix3::Zero();
  for (auto j = static_cast<Eigen::Index>(joints.size()) - 1; j >= 0; --j) {
    for (const PointWrench& load : loads) {
      if (load.joints != j + 1) continue;
      const Vector3 f = load.wrench.head<3>(), r = load.point - kinematics.end.position();
      force += f;
      moment += load.wrench.tail<3>();
      turning += r * f.transpose() - r.dot(f) * Matrix3::Identity();
    }
    const Vector3 v = twists.col(j).head<3>(), w = twists.col(j).tail<3>();
    const Vector3 by_force = v.cross(force) + turning * w, by_moment = w.cross(moment);
    const Eigen::Index l = joints[static_cast<std::size_t>(j)].coordinate;
    hessian(l, l) += w.dot(by_force);
    for (Eigen::Index i = 0; i < j; ++i) {
      const Eigen::Index k = joints[static_cast<std::size_t>(i)].coordinate;
      const double f = twists.col(i).tail<3>().dot(by_force);
      hessian(l, k) += f + twists.col(i).tail<3>().dot(by_moment);
      hessian(k, l) += f;
    }
  }
}

}  // namespace kinetostat::vjm
