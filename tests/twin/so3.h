// Rotations of the twin. Nothing here is shared with the product.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace twin {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// [v]x, so that [v]x u = v x u.
inline Matrix3 cross_matrix(const Vector3& v) {
  return (Matrix3() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
}

/// Rotation of a rotation vector [rad].
inline Matrix3 rotation_of(const Vector3& v) {
  const double angle = v.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, v / angle).toRotationMatrix() : Matrix3::Identity();
}

/// Rotation vector of a rotation, at most pi long.
inline Vector3 vector_of(const Matrix3& rotation) {
  const Eigen::Quaterniond q(rotation);
  const Vector3 v = q.w() < 0 ? Vector3(-q.vec()) : Vector3(q.vec());
  const double sine = v.norm();
  return sine < 1e-12 ? Vector3(2 * v)
                      : Vector3(v * (2 * std::atan2(sine, std::abs(q.w())) / sine));
}

/// exp(v + dv) = exp(J dv) exp(v) to first order.
inline Matrix3 left_jacobian(const Vector3& v) {
  const double angle2 = v.squaredNorm(), angle = std::sqrt(angle2);
  const double a = angle < 1e-3 ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
  const double b =
      angle < 1e-3 ? 1. / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
  const Matrix3 x = cross_matrix(v);
  return Matrix3::Identity() + a * x + b * x * x;
}

/// Its inverse.
inline Matrix3 left_jacobian_inverse(const Vector3& v) {
  const double angle2 = v.squaredNorm(), half = std::sqrt(angle2) / 2;
  const double c = half < 1e-3 ? 1. / 12 + angle2 / 720 : (1 - half / std::tan(half)) / angle2;
  const Matrix3 x = cross_matrix(v);
  return Matrix3::Identity() - 0.5 * x + c * x * x;
}

struct Pose {
  Vector3 x = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();

  Pose operator*(const Pose& behind) const { return {x + R * behind.x, R * behind.R}; }
  Vector3 operator*(const Vector3& point) const { return x + R * point; }
  Pose inverse() const { return {-(R.transpose() * x), R.transpose()}; }
};

}  // namespace twin
