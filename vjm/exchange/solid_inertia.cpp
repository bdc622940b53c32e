#include "kinetostat/vjm/exchange/solid_inertia.h"

#include <cmath>
#include <numbers>

namespace kinetostat::vjm {
namespace {

using spatial::Matrix3;
using spatial::Vector3;
using Kind = PrimitiveSolid::Kind;

double square(double x) { return x * x; }

// Of a cylinder and of the two half balls at its ends, before any scale.
double cylinder_volume(const PrimitiveSolid& s) {
  return std::numbers::pi * square(s.radius) * s.length;
}
double ball_volume(const PrimitiveSolid& s) {
  return 4.0 / 3 * std::numbers::pi * square(s.radius) * s.radius;
}

// Principal moments over the mass, about the centre: of a solid with these edges or axes.
Vector3 of_box(const Vector3& edges) {
  const Vector3 e = edges.cwiseAbs2() / 12;
  return {e.y() + e.z(), e.z() + e.x(), e.x() + e.y()};
}
Vector3 of_ellipsoid(const Vector3& semi_axes) {
  const Vector3 a = semi_axes.cwiseAbs2() / 5;
  return {a.y() + a.z(), a.z() + a.x(), a.x() + a.y()};
}
Vector3 of_cylinder(double radius, double length) {
  const double across = square(radius) / 4 + square(length) / 12;
  return {across, across, square(radius) / 2};
}

// Half balls have their centres of mass 3/8 of the radius beyond the ends of the cylinder.
Vector3 of_capsule(const PrimitiveSolid& s) {
  const double r = s.radius, l = s.length;
  const double ball = ball_volume(s) / (ball_volume(s) + cylinder_volume(s));
  const double along = 2 * square(r) / 5;
  const double across = along + square(l) / 4 + 3 * l * r / 8;
  return (1 - ball) * of_cylinder(r, l) + ball * Vector3(across, across, along);
}

Vector3 moments_over_mass(const DescribedShape& shape) {
  const PrimitiveSolid& s = shape.solid;
  if (s.kind == Kind::box) return of_box(s.edges.cwiseProduct(shape.scale));
  if (s.kind == Kind::cylinder) return of_cylinder(s.radius, s.length);
  return s.length > 0 ? of_capsule(s) : of_ellipsoid(s.radius * shape.scale);
}

// Of a mass at a point, about another one that is `arm` away.
Matrix3 steiner(double mass, const Vector3& arm) {
  return mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
}

}  // namespace

double volume(const DescribedShape& shape) {
  const PrimitiveSolid& s = shape.solid;
  const double scale = std::abs(shape.scale.prod());
  if (s.kind == Kind::box) return scale * s.edges.prod();
  return scale * (cylinder_volume(s) + (s.kind == Kind::capsule ? ball_volume(s) : 0));
}

DescribedInertia uniform_inertia(const DescribedShape& shape, double mass) {
  const Matrix3& axes = shape.pose.rotation();
  const Vector3 moments = mass * moments_over_mass(shape);
  return {.mass = mass,
          .center = shape.pose.position(),
          .tensor = axes * moments.asDiagonal() * axes.transpose()};
}

DescribedInertia together(const DescribedInertia& one, const DescribedInertia& other) {
  const double mass = one.mass + other.mass;
  if (!(mass > 0)) return one;
  const Vector3 center = (one.mass * one.center + other.mass * other.center) / mass;
  return {.mass = mass,
          .center = center,
          .tensor = one.tensor + steiner(one.mass, one.center - center) + other.tensor +
                    steiner(other.mass, other.center - center)};
}

}  // namespace kinetostat::vjm
