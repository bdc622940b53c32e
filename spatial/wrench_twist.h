// Wrenches and twists that know where they are taken.
#pragma once

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::spatial {

/// Where six coordinates are taken: the reference point [m] and the axes (columns), both given in
/// one base frame that all objects of a computation share.
struct Frame {
  Vector3 point = Vector3::Zero();
  Matrix3 axes = Matrix3::Identity();

  bool operator==(const Frame& other) const { return point == other.point && axes == other.axes; }
};

/// Maps the six coordinates [force; moment] of a wrench in `from` to those in `to`.
Matrix6 wrench_transform(const Frame& from, const Frame& to);

/// Maps the six coordinates [translation; rotation] of a twist in `from` to those in `to`. It is
/// the inverse transpose of wrench_transform(from, to): power does not depend on the frame.
Matrix6 twist_transform(const Frame& from, const Frame& to);

/// Force [N] and moment [N m] about the point of `frame`, in its axes.
struct Wrench {
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();
  Frame frame = {};

  static Wrench from_coordinates(const Vector6& force_moment, const Frame& frame = {});
  Vector6 coordinates() const;
  /// The same wrench with the moment about another point and in other axes.
  Wrench in(const Frame& other) const;
};

/// Small displacement (or velocity): translation [m] of the point of `frame` and rotation [rad], in
/// its axes.
struct Twist {
  Vector3 translation = Vector3::Zero();
  Vector3 rotation = Vector3::Zero();
  Frame frame = {};

  static Twist from_coordinates(const Vector6& translation_rotation, const Frame& frame = {});
  Vector6 coordinates() const;
  Twist in(const Frame& other) const;
};

/// Sums are taken in the frame of the left operand.
Wrench operator+(const Wrench& a, const Wrench& b);
Twist operator+(const Twist& a, const Twist& b);

/// Work [J] of a wrench along a small displacement; any two frames.
double work(const Wrench& wrench, const Twist& displacement);

}  // namespace kinetostat::spatial
