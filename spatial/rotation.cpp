#include "kinetostat/spatial/rotation.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>

namespace kinetostat::spatial {
namespace {

// Below this angle the series are exact to rounding, and the closed forms are not.
constexpr double small_angle = 1e-3;

struct SincFactors {
  double a;  // sin(t) / t
  double b;  // (1 - cos(t)) / t^2
  double c;  // (t - sin(t)) / t^3
};

SincFactors sinc_factors(double angle) {
  const double t2 = angle * angle;
  if (angle < small_angle) {
    return {1 - t2 / 6 + t2 * t2 / 120, 0.5 - t2 / 24 + t2 * t2 / 720,
            1.0 / 6 - t2 / 120 + t2 * t2 / 5040};
  }
  const double half_sine = std::sin(angle / 2);
  return {std::sin(angle) / angle, 2 * half_sine * half_sine / t2,
          (angle - std::sin(angle)) / (t2 * angle)};
}

}  // namespace

Matrix3 exp_rotation(const Vector3& rotation_vector) {
  const SincFactors f = sinc_factors(rotation_vector.norm());
  const Matrix3 s = skew(rotation_vector);
  return Matrix3::Identity() + f.a * s + f.b * s * s;
}

Vector3 log_rotation(const Matrix3& rotation) {
  // Through the unit quaternion, which is well conditioned at every angle (Shepperd's choice of
  // pivot).
  const Eigen::Quaterniond q(rotation);
  const Vector3 v = q.vec();
  const double sine = v.norm();
  if (sine < 1e-12) return 2.0 * v * (q.w() < 0 ? -1.0 : 1.0);
  if (std::abs(q.w()) < 1e-15) {
    Eigen::Index first = 0;
    while (std::abs(v[first]) < 1e-12) ++first;
    return (v[first] < 0 ? -1.0 : 1.0) * (M_PI / sine) * v;
  }
  // atan of the ratio is in (-pi/2, pi/2), so the angle is in (-pi, pi) whatever the sign of w.
  return (2.0 * std::atan(sine / q.w()) / sine) * v;
}

Matrix3 left_jacobian(const Vector3& rotation_vector) {
  const SincFactors f = sinc_factors(rotation_vector.norm());
  const Matrix3 s = skew(rotation_vector);
  return Matrix3::Identity() + f.b * s + f.c * s * s;
}

Matrix3 left_jacobian_inverse(const Vector3& rotation_vector) {
  const double t = rotation_vector.norm();
  const Matrix3 s = skew(rotation_vector);
  const double factor = t < small_angle
                            ? 1.0 / 12 + t * t / 720
                            : (1.0 - 0.5 * t * std::cos(t / 2) / std::sin(t / 2)) / (t * t);
  return Matrix3::Identity() - 0.5 * s + factor * s * s;
}

Matrix3 rotation_from_rpy(const Vector3& roll_pitch_yaw) {
  return (Eigen::AngleAxisd(roll_pitch_yaw.z(), Vector3::UnitZ()) *
          Eigen::AngleAxisd(roll_pitch_yaw.y(), Vector3::UnitY()) *
          Eigen::AngleAxisd(roll_pitch_yaw.x(), Vector3::UnitX()))
      .toRotationMatrix();
}

Matrix3 rotation_from_axes(const Vector3& x, const Vector3& y) {
  const double area = x.cross(y).norm();
  if (!(area > 1e-9 * x.norm() * y.norm()))
    throw std::invalid_argument("the two axis directions must be non-zero and not parallel");
  Matrix3 rotation;
  rotation.col(0) = x.normalized();
  rotation.col(2) = x.cross(y) / area;
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  return rotation;
}

bool is_rotation(const Matrix3& matrix, double tolerance) {
  return matrix.allFinite() &&
         (matrix.transpose() * matrix - Matrix3::Identity()).cwiseAbs().maxCoeff() <= tolerance &&
         matrix.determinant() > 0;
}

}  // namespace kinetostat::spatial
