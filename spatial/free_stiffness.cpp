#include "kinetostat/spatial/free_stiffness.h"

#include <stdexcept>

#include <Eigen/Cholesky>

namespace kinetostat::spatial {

Eigen::MatrixXd free_stiffness(const Eigen::MatrixXd& flexibility,
                               const std::vector<Vector3>& points, std::size_t held) {
  const Eigen::Index size = flexibility.rows();
  // Deformation: motion of the others beyond the rigid motion of the held one.
  Eigen::MatrixXd deformation = Eigen::MatrixXd::Zero(size, size + 6);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == held) continue;
    auto rows = deformation.middleRows<6>(row);
    rows.middleCols<6>(6 * static_cast<Eigen::Index>(i)).setIdentity();
    auto rigid = rows.middleCols<6>(6 * static_cast<Eigen::Index>(held));
    rigid.topRows<3>() = -rigid_motion(points[i] - points[held]);
    rigid.bottomRightCorner<3, 3>() = -Matrix3::Identity();
    row += 6;
  }
  // Lengths and angles differ by orders of magnitude: factorised with a diagonal of ones.
  const Eigen::VectorXd scale = flexibility.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled =
      scale.asDiagonal() * (0.5 * (flexibility + flexibility.transpose())) * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled);
  if (factor.info() != Eigen::Success)
    throw std::domain_error("the flexibility is not positive definite");
  const Eigen::MatrixXd half = factor.matrixL().solve(scale.asDiagonal() * deformation);
  return half.transpose() * half;
}

}  // namespace kinetostat::spatial
