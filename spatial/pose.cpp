#include "kinetostat/spatial/pose.h"

#include <stdexcept>

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::spatial {

Pose::Pose(const Matrix3& rotation, const Vector3& position)
    : rotation_(rotation), position_(position) {
  if (!is_rotation(rotation, 1e-6))
    throw std::invalid_argument("the rotation matrix is not orthonormal and right-handed");
}

Pose Pose::inverse() const {
  return {Unchecked{}, rotation_.transpose(), -(rotation_.transpose() * position_)};
}

Pose Pose::operator*(const Pose& other) const {
  return {Unchecked{}, rotation_ * other.rotation_, rotation_ * other.position_ + position_};
}

Pose exp_pose(const Vector6& screw) {
  const Vector3 w = screw.tail<3>();
  return {exp_rotation(w), left_jacobian(w) * screw.head<3>()};
}

Vector6 log_pose(const Pose& pose) {
  Vector6 screw;
  screw.tail<3>() = log_rotation(pose.rotation());
  screw.head<3>() = left_jacobian_inverse(screw.tail<3>()) * pose.position();
  return screw;
}

Vector6 pose_difference(const Pose& from, const Pose& to) {
  Vector6 difference;
  difference << to.position() - from.position(),
      log_rotation(to.rotation() * from.rotation().transpose());
  return difference;
}

Pose displaced(const Pose& from, const Vector6& displacement) {
  return {exp_rotation(displacement.tail<3>()) * from.rotation(),
          from.position() + displacement.head<3>()};
}

}  // namespace kinetostat::spatial
