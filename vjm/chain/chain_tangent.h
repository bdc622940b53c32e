// The derivatives of the balance of one chain at a state. Internal to this module.
#pragma once

#include "kinetostat/vjm/chain/chain_residuals.h"

namespace kinetostat::vjm {

/// The matrix of a chain (ChainEquations) at a state, scaled. Of the residuals that it is built
/// from it keeps what it needs: these may move on. When the chain starts from a body that moves,
/// the derivatives with respect to that body's displacement are given too.
class ChainTangent {
 public:
  explicit ChainTangent(const ChainResiduals& at);
  /// The same of the same chain at another state. Allocates nothing.
  void renew(const ChainResiduals& at);

  const ChainEquations& equations() const { return *equations_; }
  Eigen::Index size() const { return equations_->size(); }
  /// (6 + size()) square. Rows of held() say dx = 0.
  const Eigen::MatrixXd& matrix() const { return matrix_; }
  const std::vector<Eigen::Index>& held() const { return *held_; }

  /// 6 x size().
  Eigen::MatrixXd jacobian() const { return equations_->scaled_jacobian(jacobian_); }
  /// Second derivative of the energy: -(lower block + its transpose) / 2.
  Eigen::MatrixXd energy_hessian() const;
  /// Rounding of the energy, as EnergyHessian has it.
  Eigen::VectorXd energy_rounding() const;

  /// With a moving origin: displacement of the end (6x6), derivative of the balance (size() x 6),
  /// of the wrench on the origin with respect to x (6 x size()) and to the origin (6x6).
  const spatial::Matrix6& end_by_origin() const { return end_by_origin_; }
  const Eigen::MatrixXd& balance_by_origin() const { return balance_by_origin_; }
  const Eigen::MatrixXd& origin_by_balance() const { return origin_by_balance_; }
  const spatial::Matrix6& origin_by_origin() const { return origin_by_origin_; }

 private:
  double scaled_hessian(Eigen::Index k, Eigen::Index l) const;
  void build_hessian(const ChainResiduals& at);
  void build_matrix();
  void build_by_origin(const ChainResiduals& at);

  const ChainEquations* equations_;
  const std::vector<Eigen::Index>* held_ = nullptr;
  Matrix6X jacobian_;  // of all coordinates, as it is
  double loads_ = 0;   // sum of their scaled magnitudes
  Eigen::MatrixXd hessian_, matrix_, by_x_, by_origin_;
  spatial::Matrix6 end_by_origin_ = spatial::Matrix6::Zero();
  spatial::Matrix6 origin_by_origin_ = spatial::Matrix6::Zero();
  Eigen::MatrixXd balance_by_origin_, origin_by_balance_;
};

}  // namespace kinetostat::vjm
