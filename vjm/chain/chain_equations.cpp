#include "kinetostat/vjm/chain/chain_equations.h"

#include <algorithm>

#include "kinetostat/vjm/chain/redundant_passive.h"
#include "kinetostat/vjm/chain/robust_factor.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector6;

Vector6 Scale::twist() const {
  Vector6 s = Vector6::Ones();
  s.tail<3>().setConstant(length);
  return s;
}

Vector6 Scale::wrench() const { return twist().cwiseInverse() / stiffness; }

ChainEquations::ChainEquations(const Chain& chain, VectorXd commands, const Scale& scale,
                               bool origin_moves, const ChainKinematics& kinematics, double weight)
    : chain_(chain),
      commands_(std::move(commands)),
      rest_(chain.rest_for(commands_)),
      scale_(scale),
      origin_moves_(origin_moves) {
  const std::vector<Index>& free = chain.free_coordinates();
  unit_.resize(size());
  for (Index k = 0; k < size(); ++k) {
    const auto c = static_cast<std::size_t>(free[static_cast<std::size_t>(k)]);
    unit_[k] = weight * (is_rotation(chain.coordinates()[c].motion) ? scale.length : 1.0);
  }
  for (const Index coordinate : redundant_passive(chain, kinematics))
    redundant_.push_back(std::find(free.begin(), free.end(), coordinate) - free.begin());
  rigid_ = !is_clearly_positive(products_of_rows(kinematics.jacobian)) &&
           !has_full_row_rank(scaled_jacobian(kinematics.jacobian));
}

// Of the scaled Jacobian.
spatial::Matrix6 ChainEquations::products_of_rows(const Matrix6X& jacobian) const {
  const Vector6 to_scaled = scale_.twist();
  spatial::Matrix6 products = spatial::Matrix6::Zero();
  for (Index k = 0; k < size(); ++k) {
    const Vector6 twist = to_scaled.cwiseProduct(
        jacobian.col(free()[static_cast<std::size_t>(k)]).head<6>() / unit_[k]);
    products += twist * twist.transpose();
  }
  return products;
}

MatrixXd ChainEquations::scaled_jacobian(const Matrix6X& jacobian) const {
  return scale_.twist().asDiagonal() * jacobian(Eigen::all, free()) *
         unit_.cwiseInverse().asDiagonal();
}

void ChainEquations::gather_force(const VectorXd& full, VectorXd& scaled) const {
  scaled.resize(size());
  for (Index k = 0; k < size(); ++k)
    scaled[k] = full[free()[static_cast<std::size_t>(k)]] / (unit_[k] * scale_.stiffness);
}

VectorXd ChainEquations::full_increment(const VectorXd& scaled) const {
  VectorXd full = VectorXd::Zero(chain_.size());
  full(free()) = scaled.cwiseQuotient(unit_);
  return full;
}

void ChainEquations::add_increment(const VectorXd& scaled, double factor, VectorXd& full) const {
  for (Index k = 0; k < size(); ++k)
    full[free()[static_cast<std::size_t>(k)]] += factor * scaled[k] / unit_[k];
}

VectorXd ChainEquations::scaled_increment(const VectorXd& full) const {
  return full(free()).cwiseProduct(unit_);
}

bool ChainEquations::kinks(const VectorXd& from, VectorXd& to) const {
  bool any = false;
  for (const auto& [k, law] : chain_.laws()) {
    double step = to[k] - from[k];
    if (!law->kinks({from[k], from[k] - rest_[k], chain_.stiffness()(k, k), from[k] - commands_[k]},
                    step))
      continue;
    any = true;
    to[k] = from[k] + step;
  }
  return any;
}

}  // namespace kinetostat::vjm
