// Random vectors, rotations and matrices for property tests, from an explicit seed.
#pragma once

#include <random>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/spatial/wrench_twist.h"

namespace kinetostat::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  /// Entries in [-size, size].
  template <int Rows, int Columns = 1>
  Eigen::Matrix<double, Rows, Columns> matrix(double size = 1) {
    return Eigen::Matrix<double, Rows, Columns>::NullaryExpr(
        [this, size]() { return uniform(-size, size); });
  }
  spatial::Vector3 vector(double size = 1) { return matrix<3>(size); }
  /// A unit vector.
  spatial::Vector3 direction() {
    spatial::Vector3 v = vector();
    while (v.norm() < 0.1) v = vector();
    return v.normalized();
  }
  spatial::Matrix3 rotation() { return spatial::exp_rotation(uniform(0, 3.1) * direction()); }
  spatial::Pose pose() { return {rotation(), vector()}; }
  spatial::Frame frame() { return {vector(), rotation()}; }
  /// Symmetric, eigenvalues between about 0.1 and 10.
  spatial::Matrix6 positive_definite() {
    const spatial::Matrix6 a = matrix<6, 6>();
    return a * a.transpose() + 0.1 * spatial::Matrix6::Identity();
  }

 private:
  std::mt19937 engine_;
};

}  // namespace kinetostat::test
