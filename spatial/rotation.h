// Rotation matrices and rotation vectors (axis times angle [rad]).
#pragma once

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::spatial {

/// Rotation matrix of a rotation vector (Rodrigues' formula); exact to rounding at and near zero.
Matrix3 exp_rotation(const Vector3& rotation_vector);

/// Rotation vector of a rotation matrix, length in [0, pi]. At exactly pi, where v and -v are the
/// same rotation, the one whose first non-zero component is positive is returned.
Vector3 log_rotation(const Matrix3& rotation);

/// Left Jacobian of the exponential: exp(v + dv) ~ exp(J dv) exp(v).
Matrix3 left_jacobian(const Vector3& rotation_vector);

/// Inverse of the left Jacobian; requires |v| < 2 pi.
Matrix3 left_jacobian_inverse(const Vector3& rotation_vector);

/// Rotation about the fixed axes x, then y, then z: Rz(yaw) Ry(pitch) Rx(roll), angles in [rad].
Matrix3 rotation_from_rpy(const Vector3& roll_pitch_yaw);

/// Rotation whose x axis is along `x` and whose y axis lies in the half plane of `y`. The vectors
/// need not be unit or orthogonal. Throws std::invalid_argument when they are zero or parallel.
Matrix3 rotation_from_axes(const Vector3& x, const Vector3& y);

/// True when R'R = I and det R = +1 to within `tolerance` per entry.
bool is_rotation(const Matrix3& matrix, double tolerance = 1e-9);

}  // namespace kinetostat::spatial
