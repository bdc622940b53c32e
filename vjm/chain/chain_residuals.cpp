#include "kinetostat/vjm/chain/chain_residuals.h"

#include <cassert>

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::VectorXd;
using spatial::Vector6;

ChainResiduals::ChainResiduals(const ChainEquations& equations, NodeWrenches node_loads,
                               const spatial::Pose& origin, const VectorXd& x,
                               const Vector6& wrench, CoordinateForces joint_loads)
    : equations_(&equations),
      node_loads_(std::move(node_loads)),
      joint_loads_(std::move(joint_loads)) {
  move_to(origin, x, wrench);
}

void ChainResiduals::move_to(const spatial::Pose& origin, const VectorXd& x,
                             const Vector6& wrench) {
  assert(x.size() == equations_->chain().size());
  origin_ = origin;
  x_ = x;
  deflection_ = x_ - equations_->rest();
  travel_ = x_ - equations_->commands();
  evaluate(equations_->chain(), x, kinematics_, origin);
  gather_loads(wrench);
  balance(wrench);
}

void ChainResiduals::gather_loads(const Vector6& wrench) {
  loads_.clear();
  loads_.push_back(at_end(equations_->chain(), kinematics_, wrench));
  for (const auto& [node, load] : node_loads_)
    loads_.push_back(at_node(equations_->chain(), kinematics_, node, load));
}

void ChainResiduals::balance(const Vector6& wrench) {
  const Chain& chain = equations_->chain();
  force_.resize(chain.size());
  force_.noalias() = kinematics_.jacobian.transpose() * wrench;
  force_.noalias() -= chain.stiffness() * deflection_;
  for (std::size_t n = 1; n < loads_.size(); ++n)
    add_generalised_force(chain, kinematics_, loads_[n], force_);
  for (const auto& [coordinate, law] : chain.laws())
    force_[coordinate] -= value_of(coordinate, *law).force;
  for (const auto& [coordinate, force] : joint_loads_) force_[coordinate] += force;
  unbalanced_.resize(equations_->size());
  for (Index k = 0; k < equations_->size(); ++k)
    unbalanced_[k] = force_[equations_->free()[static_cast<std::size_t>(k)]] /
                     (equations_->unit()[k] * equations_->scale().stiffness);
}

const std::vector<Index>& ChainResiduals::held() const {
  static const std::vector<Index> none;
  return node_loads_.empty() && joint_loads_.empty() ? equations_->redundant() : none;
}

CoordinateLaw::Value ChainResiduals::value_of(Index coordinate, const CoordinateLaw& law) const {
  return equations_->chain().value_of(coordinate, law, x_, deflection_, travel_);
}

Vector6 ChainResiduals::wrench_on_origin() const {
  Vector6 sum = Vector6::Zero();
  for (const PointWrench& load : loads_) {
    sum += load.wrench;
    sum.tail<3>() += (load.point - origin_.position()).cross(load.wrench.head<3>());
  }
  return sum;
}

void ChainResiduals::add_force_by_log_stiffness(const Spring& spring, bool of_drive,
                                                VectorXd& force) const {
  const Chain& chain = equations_->chain();
  const Index n = spring.stiffness.rows();
  const double share = spring.share_that_scales();
  force.segment(spring.first, n).noalias() -=
      share * spring.stiffness * deflection_.segment(spring.first, n);
  for (const auto& [coordinate, law] : chain.laws())
    if (coordinate >= spring.first && coordinate < spring.first + n &&
        !(of_drive && law->is_beside_drive()))
      force[coordinate] -= share * chain.stiffness()(coordinate, coordinate) *
                           value_of(coordinate, *law).force_by_stiffness;
}

double ChainResiduals::energy() const {
  const Chain& chain = equations_->chain();
  double energy = 0.5 * deflection_.dot(chain.stiffness() * deflection_);
  for (const auto& [coordinate, law] : chain.laws())
    energy += law->energy(chain.joint_state(coordinate, x_, deflection_, travel_));
  return energy;
}

}  // namespace kinetostat::vjm
