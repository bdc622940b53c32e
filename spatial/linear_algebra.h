// Shorthand for the small matrices of elastostatics.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kinetostat::spatial {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The matrix of the cross product: skew(a) * b == a.cross(b).
inline Matrix3 skew(const Vector3& a) {
  Matrix3 s;
  s << 0, -a.z(), a.y(),  //
      a.z(), 0, -a.x(),   //
      -a.y(), a.x(), 0;
  return s;
}

/// Displacement of a point that follows a rigid body: u = [I, -skew(arm)] [translation; rotation],
/// with the arm from the reference point of the motion to the point [m].
inline Eigen::Matrix<double, 3, 6> rigid_motion(const Vector3& arm) {
  Eigen::Matrix<double, 3, 6> motion;
  motion << Matrix3::Identity(), -skew(arm);
  return motion;
}

}  // namespace kinetostat::spatial
