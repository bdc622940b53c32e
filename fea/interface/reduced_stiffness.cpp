#include "kinetostat/fea/interface/reduced_stiffness.h"

#include <stdexcept>

#include <Eigen/Cholesky>

namespace kinetostat::fea {

Eigen::MatrixXd reduced_stiffness(const Eigen::MatrixXd& flexibility,
                                  const std::vector<CoupledInterface>& interfaces) {
  const Eigen::Index size = flexibility.rows();
  // Deformation of the link: motion of the loaded interfaces beyond the rigid motion of the first.
  Eigen::MatrixXd deformation(size, size + 6);
  for (std::size_t i = 1; i < interfaces.size(); ++i) {
    const Vector3 arm = interfaces[i].point - interfaces[0].point;
    auto rows = deformation.middleRows<6>(6 * static_cast<Eigen::Index>(i - 1));
    rows.leftCols<6>().setIdentity();
    rows.topRows<3>().middleCols<3>(3) = -spatial::skew(arm);
    rows.leftCols<6>() *= -1;
  }
  deformation.rightCols(size).setIdentity();
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

}  // namespace kinetostat::fea
