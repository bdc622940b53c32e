#include "kinetostat/vjm/chain/chain_tangent.h"

#include <cmath>

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;

ChainTangent::ChainTangent(const ChainResiduals& at) : equations_(&at.equations()) { renew(at); }

void ChainTangent::renew(const ChainResiduals& at) {
  equations_ = &at.equations();
  held_ = &at.held();
  jacobian_ = at.kinematics().jacobian;
  const Vector6 wrench_scale = equations_->scale().wrench();
  loads_ = 0;
  for (const PointWrench& load : at.loads())
    loads_ += wrench_scale.cwiseProduct(load.wrench).norm();
  build_hessian(at);
  build_matrix();
  if (equations_->origin_moves()) build_by_origin(at);
}

void ChainTangent::build_hessian(const ChainResiduals& at) {
  const Chain& chain = equations_->chain();
  hessian_ = -chain.stiffness();
  add_wrench_hessian(chain, at.kinematics(), at.loads(), hessian_);
  for (const auto& [coordinate, law] : chain.laws())
    hessian_(coordinate, coordinate) -= at.value_of(coordinate, *law).tangent;
}

double ChainTangent::scaled_hessian(Index k, Index l) const {
  const std::vector<Index>& free = equations_->free();
  return hessian_(free[static_cast<std::size_t>(k)], free[static_cast<std::size_t>(l)]) /
         (equations_->unit()[k] * equations_->unit()[l] * equations_->scale().stiffness);
}

void ChainTangent::build_matrix() {
  const Index n = size();
  const Vector6 to_scaled = equations_->scale().twist();
  matrix_.resize(6 + n, 6 + n);
  matrix_.topLeftCorner<6, 6>().setZero();  // all else is written below
  const std::vector<Index>& free = equations_->free();
  const VectorXd& unit = equations_->unit();
  const double stiffness = equations_->scale().stiffness;
  for (Index l = 0; l < n; ++l) {
    const Index column = free[static_cast<std::size_t>(l)];
    const Vector6 twist = to_scaled.cwiseProduct(jacobian_.col(column)) / unit[l];
    matrix_.col(6 + l).head<6>() = twist;
    matrix_.row(6 + l).head<6>() = twist.transpose();
    const auto forces = hessian_.col(column);
    auto scaled = matrix_.col(6 + l).tail(n);
    for (Index k = 0; k < n; ++k) scaled[k] = forces[free[static_cast<std::size_t>(k)]];
    scaled.array() /= unit.array() * (unit[l] * stiffness);
  }
  for (const Index k : held()) {
    matrix_.row(6 + k).setZero();
    matrix_.col(6 + k).setZero();
    matrix_(6 + k, 6 + k) = -1;
  }
}

// The origin's rotation acts like three joints nearer the base than all of the chain's; its moment
// is taken about axes that do not turn.
void ChainTangent::build_by_origin(const ChainResiduals& at) {
  const Chain& chain = equations_->chain();
  const ChainKinematics& kinematics = at.kinematics();
  const Vector3& origin = at.origin().position();
  const Vector6 to_scaled = equations_->scale().twist();
  const Vector6 wrench_scale = equations_->scale().wrench();
  Matrix6 end = Matrix6::Identity(), own = Matrix6::Zero();
  end.topRightCorner<3, 3>() = -spatial::skew(kinematics.end.position() - origin);
  by_x_.setZero(6, chain.size());
  by_origin_.setZero(chain.size(), 6);
  for (const PointWrench& load : at.loads()) {
    const Vector3 force = load.wrench.head<3>(), moment = load.wrench.tail<3>();
    const Vector3 from_end = load.point - kinematics.end.position();
    own.bottomRightCorner<3, 3>() += spatial::skew(force) * spatial::skew(load.point - origin);
    for (Index j = 0; j < load.joints; ++j) {
      const Index k = chain.joints()[static_cast<std::size_t>(j)].coordinate;
      const Vector3 w = kinematics.joint_twists.col(j).tail<3>();
      const Vector3 v = kinematics.joint_twists.col(j).head<3>() + w.cross(from_end);
      const Vector3 moment_change = v.cross(force);
      by_x_.col(k).tail<3>() += moment_change;
      by_origin_.row(k).tail<3>() += (moment_change + w.cross(moment)).transpose();
    }
  }
  end_by_origin_ = to_scaled.asDiagonal() * end * to_scaled.cwiseInverse().asDiagonal();
  origin_by_origin_ = wrench_scale.asDiagonal() * own * to_scaled.cwiseInverse().asDiagonal();
  const Index n = size();
  origin_by_balance_.resize(6, n);
  balance_by_origin_.resize(n, 6);
  for (Index k = 0; k < n; ++k) {
    const Index coordinate = equations_->free()[static_cast<std::size_t>(k)];
    const double unit = equations_->unit()[k];
    origin_by_balance_.col(k).head<6>() =
        wrench_scale.cwiseProduct(by_x_.col(coordinate).head<6>()) / unit;
    balance_by_origin_.row(k).head<6>() =
        by_origin_.row(coordinate).head<6>().cwiseQuotient(to_scaled.transpose()) /
        (unit * equations_->scale().stiffness);
  }
}

MatrixXd ChainTangent::energy_hessian() const {
  MatrixXd energy(size(), size());
  for (Index l = 0; l < size(); ++l)
    for (Index k = 0; k < size(); ++k)
      energy(k, l) = -0.5 * (scaled_hessian(k, l) + scaled_hessian(l, k));
  return energy;
}

VectorXd ChainTangent::energy_rounding() const {
  constexpr double share = 1e-13;  // of a load, lost where its terms in the energy cancel
  return VectorXd::Constant(size(), std::sqrt(share * loads_));
}

}  // namespace kinetostat::vjm
