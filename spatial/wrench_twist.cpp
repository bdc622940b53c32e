#include "kinetostat/spatial/wrench_twist.h"

namespace kinetostat::spatial {

Matrix6 wrench_transform(const Frame& from, const Frame& to) {
  const Matrix3 rotation = to.axes.transpose() * from.axes;
  const Vector3 arm = to.axes.transpose() * (from.point - to.point);
  Matrix6 transform = Matrix6::Zero();
  transform.topLeftCorner<3, 3>() = rotation;
  transform.bottomRightCorner<3, 3>() = rotation;
  transform.bottomLeftCorner<3, 3>() = skew(arm) * rotation;
  return transform;
}

Matrix6 twist_transform(const Frame& from, const Frame& to) {
  return wrench_transform(to, from).transpose();
}

Wrench Wrench::from_coordinates(const Vector6& force_moment, const Frame& frame) {
  return {force_moment.head<3>(), force_moment.tail<3>(), frame};
}

Vector6 Wrench::coordinates() const {
  Vector6 c;
  c << force, moment;
  return c;
}

Wrench Wrench::in(const Frame& other) const {
  return from_coordinates(wrench_transform(frame, other) * coordinates(), other);
}

Twist Twist::from_coordinates(const Vector6& translation_rotation, const Frame& frame) {
  return {translation_rotation.head<3>(), translation_rotation.tail<3>(), frame};
}

Vector6 Twist::coordinates() const {
  Vector6 c;
  c << translation, rotation;
  return c;
}

Twist Twist::in(const Frame& other) const {
  return from_coordinates(twist_transform(frame, other) * coordinates(), other);
}

Wrench operator+(const Wrench& a, const Wrench& b) {
  return Wrench::from_coordinates(a.coordinates() + b.in(a.frame).coordinates(), a.frame);
}

Twist operator+(const Twist& a, const Twist& b) {
  return Twist::from_coordinates(a.coordinates() + b.in(a.frame).coordinates(), a.frame);
}

double work(const Wrench& wrench, const Twist& displacement) {
  return wrench.coordinates().dot(displacement.in(wrench.frame).coordinates());
}

}  // namespace kinetostat::spatial
