// 6x6 stiffness and compliance that know their reference point and axes.
#pragma once

#include "kinetostat/spatial/wrench_twist.h"

namespace kinetostat::spatial {

class Compliance6;

/// The linear map from a small displacement [translation; rotation] to a wrench [force; moment],
/// both taken in `frame()`. Blocks in [N/m, N/rad; N m/m, N m/rad]. Rank-deficient and
/// (under load) non-symmetric matrices are allowed.
class Stiffness6 {
 public:
  explicit Stiffness6(const Matrix6& matrix, const Frame& frame = {})
      : matrix_(matrix), frame_(frame) {}

  const Matrix6& matrix() const { return matrix_; }
  const Frame& frame() const { return frame_; }

  /// The same spring taken at another point and in other axes (IROS11 eq. 11-12).
  Stiffness6 in(const Frame& other) const;
  /// Wrench, in the frame of the stiffness, that goes with a small displacement.
  Wrench operator*(const Twist& displacement) const;
  /// Throws std::domain_error when the matrix is singular to working precision.
  Compliance6 inverse() const;

 private:
  Matrix6 matrix_;
  Frame frame_;
};

/// The linear map from a wrench to the small displacement, both taken in `frame()`. Blocks in
/// [m/N, m/(N m); rad/N, rad/(N m)].
class Compliance6 {
 public:
  explicit Compliance6(const Matrix6& matrix, const Frame& frame = {})
      : matrix_(matrix), frame_(frame) {}

  const Matrix6& matrix() const { return matrix_; }
  const Frame& frame() const { return frame_; }

  Compliance6 in(const Frame& other) const;
  Twist operator*(const Wrench& wrench) const;
  /// Throws std::domain_error when the matrix is singular to working precision.
  Stiffness6 inverse() const;

 private:
  Matrix6 matrix_;
  Frame frame_;
};

/// Springs in parallel between the same two bodies: stiffness adds, in the frame of the left
/// operand.
Stiffness6 operator+(const Stiffness6& a, const Stiffness6& b);
/// Springs in series: compliance adds, in the frame of the left operand.
Compliance6 operator+(const Compliance6& a, const Compliance6& b);

/// Largest |A - A'| relative to the largest |A|, after scaling lengths so that the diagonals of the
/// translational and rotational blocks are comparable. 0 for a zero matrix.
double symmetry_defect(const Matrix6& matrix);

/// Eigen-stiffnesses with translation and rotation kept apart, so that no length has to be chosen
/// to compare them: under a pure force at the reference point, and under a pure moment; the other
/// motion is free to follow. Reciprocals of the eigenvalues of the two diagonal compliance blocks,
/// ascending.
struct EigenStiffness {
  Vector3 translation;       // [N/m]
  Matrix3 translation_axes;  // columns, in the axes of the frame
  Vector3 rotation;          // [N m/rad]
  Matrix3 rotation_axes;
};
EigenStiffness eigen_stiffness(const Compliance6& compliance);

}  // namespace kinetostat::spatial
