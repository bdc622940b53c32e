#include "kinetostat/vjm/kinematics.h"

#include <cmath>

namespace kinetostat::vjm {
namespace {

using spatial::Matrix3;
using spatial::Vector3;
using spatial::Vector6;

// Turns the frame about its own axis: only the two other columns change.
void turn(Matrix3& rotation, int axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  const Vector3 u = rotation.col(a), v = rotation.col(b);
  rotation.col(a) = c * u + s * v;
  rotation.col(b) = c * v - s * u;
}

}  // namespace

void evaluate(const Chain& chain, const Eigen::VectorXd& x, ChainKinematics& kinematics) {
  const auto joints = static_cast<Eigen::Index>(chain.joints().size());
  Matrix6X& twists = kinematics.joint_twists;
  twists.resize(6, joints);
  Matrix3 rotation = Matrix3::Identity();
  Vector3 position = Vector3::Zero();

  // First pass: the axis of each joint in the tail rows, its origin in the head rows.
  for (Eigen::Index j = 0; j < joints; ++j) {
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

void wrench_hessian(const Chain& chain, const ChainKinematics& kinematics, const Vector6& wrench,
                    Eigen::MatrixXd& result) {
  const Vector3 force = wrench.head<3>(), moment = wrench.tail<3>();
  const Matrix6X& twists = kinematics.joint_twists;
  const auto& joints = chain.joints();
  result.setZero(chain.size(), chain.size());
  for (Eigen::Index i = 0; i < twists.cols(); ++i) {
    const Joint& inner = joints[static_cast<std::size_t>(i)];
    if (!is_rotation(inner.motion)) continue;  // every term has w_i
    const Vector3 w = twists.col(i).tail<3>();
    // f . (w x v) = (f x w) . v
    const Vector3 force_arm = force.cross(w), moment_arm = moment.cross(w);
    const Eigen::Index k = inner.coordinate;
    result(k, k) += force_arm.dot(twists.col(i).head<3>());
    for (Eigen::Index j = i + 1; j < twists.cols(); ++j) {
      const Eigen::Index l = joints[static_cast<std::size_t>(j)].coordinate;
      const double f = force_arm.dot(twists.col(j).head<3>());
      result(l, k) += f + moment_arm.dot(twists.col(j).tail<3>());
      result(k, l) += f;
    }
  }
}

}  // namespace kinetostat::vjm
