// Position and rotation of a frame.
#pragma once

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::spatial {

/// Where a frame B stands in a frame A: p_A = rotation * p_B + position. Lengths in [m].
class Pose {
 public:
  /// The identity.
  Pose() = default;
  /// Throws std::invalid_argument when `rotation` is not a rotation matrix.
  Pose(const Matrix3& rotation, const Vector3& position);

  static Pose translation(const Vector3& position) { return {Matrix3::Identity(), position}; }
  static Pose rotation(const Matrix3& rotation) { return {rotation, Vector3::Zero()}; }

  const Vector3& position() const { return position_; }
  const Matrix3& rotation() const { return rotation_; }

  Pose inverse() const;
  /// X_AC = X_AB * X_BC.
  Pose operator*(const Pose& other) const;
  /// A point given in B, returned in A.
  Vector3 operator*(const Vector3& point) const { return rotation_ * point + position_; }

 private:
  struct Unchecked {};
  Pose(Unchecked, const Matrix3& rotation, const Vector3& position)
      : rotation_(rotation), position_(position) {}

  Matrix3 rotation_ = Matrix3::Identity();
  Vector3 position_ = Vector3::Zero();
};

/// Screw motion: the pose reached from the identity by moving for unit time with the constant
/// twist [translation velocity of the origin; angular velocity], both in the fixed frame.
Pose exp_pose(const Vector6& screw);

/// The inverse of exp_pose, rotation angle in [0, pi].
Vector6 log_pose(const Pose& pose);

/// How far `to` is from `from`: [difference of positions [m]; rotation vector [rad]], both in the
/// axes of the frame in which the two poses are given. This is the displacement that the equations
/// of equilibrium use (translation of the end point itself, not of the fixed origin).
Vector6 pose_difference(const Pose& from, const Pose& to);

/// The pose reached from `from` by the displacement [translation; rotation vector], so that
/// pose_difference(from, displaced(from, d)) == d for rotations below pi.
Pose displaced(const Pose& from, const Vector6& displacement);

}  // namespace kinetostat::spatial
