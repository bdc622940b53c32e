#include "kinetostat/spatial/stiffness.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace kinetostat::spatial {
namespace {

// Row and column factors that make the blocks comparable: 1 and one over the length that is the
// ratio of the rotational to the translational diagonal.
Vector6 comparable(const Matrix6& matrix) {
  const double translation = matrix.diagonal().head<3>().cwiseAbs().maxCoeff();
  const double rotation = matrix.diagonal().tail<3>().cwiseAbs().maxCoeff();
  Vector6 scale = Vector6::Ones();
  if (translation > 0 && rotation > 0)
    scale.tail<3>().setConstant(1.0 / std::sqrt(rotation / translation));
  return scale;
}

Matrix6 checked_inverse(const Matrix6& matrix, const char* what) {
  const Vector6 scale = comparable(matrix);
  const Eigen::FullPivLU<Matrix6> lu(scale.asDiagonal() * matrix * scale.asDiagonal());
  if (!matrix.allFinite() || !lu.isInvertible())
    throw std::domain_error(std::string("the ") + what + " matrix is singular");
  return scale.asDiagonal() * lu.inverse() * scale.asDiagonal();
}

void reciprocal_eigenvalues(const Matrix3& compliance, Vector3& stiffness, Matrix3& axes) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(0.5 * (compliance + compliance.transpose()));
  stiffness = solver.eigenvalues().cwiseInverse().reverse();
  axes = solver.eigenvectors().rowwise().reverse();
}

}  // namespace

Stiffness6 Stiffness6::in(const Frame& other) const {
  return Stiffness6(wrench_transform(frame_, other) * matrix_ * twist_transform(other, frame_),
                    other);
}

Wrench Stiffness6::operator*(const Twist& displacement) const {
  return Wrench::from_coordinates(matrix_ * displacement.in(frame_).coordinates(), frame_);
}

Compliance6 Stiffness6::inverse() const {
  return Compliance6(checked_inverse(matrix_, "stiffness"), frame_);
}

Compliance6 Compliance6::in(const Frame& other) const {
  return Compliance6(twist_transform(frame_, other) * matrix_ * wrench_transform(other, frame_),
                     other);
}

Twist Compliance6::operator*(const Wrench& wrench) const {
  return Twist::from_coordinates(matrix_ * wrench.in(frame_).coordinates(), frame_);
}

Stiffness6 Compliance6::inverse() const {
  return Stiffness6(checked_inverse(matrix_, "compliance"), frame_);
}

Stiffness6 operator+(const Stiffness6& a, const Stiffness6& b) {
  return Stiffness6(a.matrix() + b.in(a.frame()).matrix(), a.frame());
}

Compliance6 operator+(const Compliance6& a, const Compliance6& b) {
  return Compliance6(a.matrix() + b.in(a.frame()).matrix(), a.frame());
}

double symmetry_defect(const Matrix6& matrix) {
  const Vector6 scale = comparable(matrix);
  const Matrix6 m = scale.asDiagonal() * matrix * scale.asDiagonal();
  const double largest = m.cwiseAbs().maxCoeff();
  return largest > 0 ? (m - m.transpose()).cwiseAbs().maxCoeff() / largest : 0.0;
}

EigenStiffness eigen_stiffness(const Compliance6& compliance) {
  EigenStiffness result;
  reciprocal_eigenvalues(compliance.matrix().topLeftCorner<3, 3>(), result.translation,
                         result.translation_axes);
  reciprocal_eigenvalues(compliance.matrix().bottomRightCorner<3, 3>(), result.rotation,
                         result.rotation_axes);
  return result;
}

}  // namespace kinetostat::spatial
