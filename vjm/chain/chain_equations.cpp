#include "kinetostat/vjm/chain/chain_equations.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/vjm/chain/redundant_passive.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;

Vector6 Scale::twist() const {
  Vector6 s = Vector6::Ones();
  s.tail<3>().setConstant(length);
  return s;
}

Vector6 Scale::wrench() const { return twist().cwiseInverse() / stiffness; }

ChainEquations::ChainEquations(const Chain& chain, VectorXd commands, const Scale& scale,
                               bool origin_moves)
    : chain_(chain),
      commands_(std::move(commands)),
      rest_(chain.rest_for(commands_)),
      scale_(scale),
      origin_moves_(origin_moves),
      free_(chain.free_coordinates()) {
  unit_.resize(size());
  for (Index k = 0; k < size(); ++k) {
    const auto c = static_cast<std::size_t>(free_[static_cast<std::size_t>(k)]);
    unit_[k] = is_rotation(chain.coordinates()[c].motion) ? scale.length : 1.0;
  }
}

void ChainEquations::set(const spatial::Pose& origin, const VectorXd& x, const Vector6& wrench) {
  origin_ = origin;
  x_ = x;
  wrench_ = wrench;
  evaluate(chain_, x, kinematics_, origin);
}

void ChainEquations::add_node_load(std::size_t node, const Vector6& wrench) {
  node_loads_.emplace_back(node, wrench);
}

std::vector<PointWrench> ChainEquations::loads() const {
  std::vector<PointWrench> all;
  for_each_load([&all](const PointWrench& load) { all.push_back(load); });
  return all;
}

// The wrench at the end, then those at nodes.
template <class Use>
void ChainEquations::for_each_load(const Use& use) const {
  use(at_end(chain_, kinematics_, wrench_));
  for (const auto& [node, load] : node_loads_) use(at_node(chain_, kinematics_, node, load));
}

VectorXd ChainEquations::gather_force(const VectorXd& full) const {
  return full(free_).cwiseQuotient(unit_) / scale_.stiffness;
}

void ChainEquations::unbalanced(VectorXd& result) const {
  deflection_ = x_ - rest_;
  travel_ = x_ - commands_;
  force_.resize(chain_.size());
  force_.noalias() = kinematics_.jacobian.transpose() * wrench_;
  force_.noalias() -= chain_.stiffness() * deflection_;
  for (const auto& [node, load] : node_loads_)
    add_generalised_force(chain_, kinematics_, at_node(chain_, kinematics_, node, load), force_);
  for (const auto& [coordinate, law] : chain_.laws())
    force_[coordinate] -= chain_.value_of(coordinate, *law, x_, deflection_, travel_).force;
  result.resize(size());
  for (Index k = 0; k < size(); ++k)
    result[k] = force_[free_[static_cast<std::size_t>(k)]] / (unit_[k] * scale_.stiffness);
}

Vector6 ChainEquations::wrench_on_origin() const {
  Vector6 sum = Vector6::Zero();
  for_each_load([&](const PointWrench& load) {
    sum += load.wrench;
    sum.tail<3>() += (load.point - origin_.position()).cross(load.wrench.head<3>());
  });
  return sum;
}

MatrixXd ChainEquations::jacobian() const {
  return scale_.twist().asDiagonal() * kinematics_.jacobian(Eigen::all, free_) *
         unit_.cwiseInverse().asDiagonal();
}

double ChainEquations::scaled_hessian(Index k, Index l) const {
  return hessian_(free_[static_cast<std::size_t>(k)], free_[static_cast<std::size_t>(l)]) /
         (unit_[k] * unit_[l] * scale_.stiffness);
}

MatrixXd ChainEquations::energy_hessian() const {
  MatrixXd energy(size(), size());
  for (Index l = 0; l < size(); ++l)
    for (Index k = 0; k < size(); ++k)
      energy(k, l) = -0.5 * (scaled_hessian(k, l) + scaled_hessian(l, k));
  return energy;
}

VectorXd ChainEquations::energy_rounding() const {
  constexpr double share = 1e-13;  // of a load, lost where its terms in the energy cancel
  double loads = 0;
  for_each_load(
      [&](const PointWrench& load) { loads += scale_.wrench().cwiseProduct(load.wrench).norm(); });
  return VectorXd::Constant(size(), std::sqrt(share * loads));
}

VectorXd ChainEquations::force_by_log_stiffness(const Spring& spring) const {
  VectorXd force = VectorXd::Zero(chain_.size());
  const Index n = spring.stiffness.rows();
  const VectorXd deflection = x_ - rest_;
  // A compliance c in series does not scale: dK/dlog k0 = K (1 - K c) with 1/K = 1/k0 + c.
  const double share = spring.series > 0 ? 1 - spring.stiffness(0, 0) * spring.series : 1;
  force.segment(spring.first, n) = -share * spring.stiffness * deflection.segment(spring.first, n);
  for (const auto& [coordinate, law] : chain_.laws())
    if (coordinate >= spring.first && coordinate < spring.first + n)
      force[coordinate] -=
          share * chain_.stiffness()(coordinate, coordinate) *
          chain_.value_of(coordinate, *law, x_, deflection, travel()).force_by_stiffness;
  return force;
}

double ChainEquations::energy() const {
  const VectorXd deflection = x_ - rest_;
  double energy = 0.5 * deflection.dot(chain_.stiffness() * deflection);
  for (const auto& [coordinate, law] : chain_.laws())
    energy += chain_.value_of(coordinate, *law, x_, deflection, travel()).energy;
  return energy;
}

VectorXd ChainEquations::full_increment(const VectorXd& scaled) const {
  VectorXd full = VectorXd::Zero(chain_.size());
  full(free_) = scaled.cwiseQuotient(unit_);
  return full;
}

VectorXd ChainEquations::scaled_increment(const VectorXd& full) const {
  return full(free_).cwiseProduct(unit_);
}

void ChainEquations::add_increment(const VectorXd& scaled, double factor, VectorXd& full) const {
  for (Index k = 0; k < size(); ++k)
    full[free_[static_cast<std::size_t>(k)]] += factor * scaled[k] / unit_[k];
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

void ChainEquations::hold_redundant() {
  redundant_.clear();
  for (const Index coordinate : redundant_passive(chain_, kinematics_))
    redundant_.push_back(std::find(free_.begin(), free_.end(), coordinate) - free_.begin());
}

const std::vector<Index>& ChainEquations::held() const {
  static const std::vector<Index> none;
  return node_loads_.empty() ? redundant_ : none;
}

void ChainEquations::linearise(bool factorise) {
  const Index n = size();
  hessian_ = -chain_.stiffness();
  deflection_ = x_ - rest_;
  travel_ = x_ - commands_;
  for_each_load(
      [this](const PointWrench& load) { add_wrench_hessian(chain_, kinematics_, load, hessian_); });
  for (const auto& [coordinate, law] : chain_.laws())
    hessian_(coordinate, coordinate) -=
        chain_.value_of(coordinate, *law, x_, deflection_, travel_).tangent;
  const Vector6 to_scaled = scale_.twist();
  matrix_.setZero(6 + n, 6 + n);
  for (Index l = 0; l < n; ++l) {
    const Index column = free_[static_cast<std::size_t>(l)];
    const Vector6 twist = to_scaled.cwiseProduct(kinematics_.jacobian.col(column)) / unit_[l];
    matrix_.col(6 + l).head<6>() = twist;
    matrix_.row(6 + l).head<6>() = twist.transpose();
    for (Index k = 0; k < n; ++k) matrix_(6 + k, 6 + l) = scaled_hessian(k, l);
  }
  for (const Index k : held()) {
    matrix_.row(6 + k).setZero();
    matrix_.col(6 + k).setZero();
    matrix_(6 + k, 6 + k) = -1;
  }
  if (factorise) factor_.compute(matrix_);
  if (origin_moves_) linearise_origin();
}

// The origin's rotation acts like three joints nearer the base than all of the chain's; its moment
// is taken about axes that do not turn.
void ChainEquations::linearise_origin() {
  const Vector6 to_scaled = scale_.twist(), wrench_scale = scale_.wrench();
  Matrix6 end = Matrix6::Identity(), own = Matrix6::Zero();
  end.topRightCorner<3, 3>() = -spatial::skew(kinematics_.end.position() - origin_.position());
  by_x_.setZero(6, chain_.size());
  by_origin_.setZero(chain_.size(), 6);
  for_each_load([&](const PointWrench& load) {
    const Vector3 force = load.wrench.head<3>(), moment = load.wrench.tail<3>();
    const Vector3 from_end = load.point - kinematics_.end.position();
    own.bottomRightCorner<3, 3>() +=
        spatial::skew(force) * spatial::skew(load.point - origin_.position());
    for (Index j = 0; j < load.joints; ++j) {
      const Index k = chain_.joints()[static_cast<std::size_t>(j)].coordinate;
      const Vector3 w = kinematics_.joint_twists.col(j).tail<3>();
      const Vector3 v = kinematics_.joint_twists.col(j).head<3>() + w.cross(from_end);
      const Vector3 moment_change = v.cross(force);
      by_x_.col(k).tail<3>() += moment_change;
      by_origin_.row(k).tail<3>() += (moment_change + w.cross(moment)).transpose();
    }
  });
  end_by_origin_ = to_scaled.asDiagonal() * end * to_scaled.cwiseInverse().asDiagonal();
  origin_by_origin_ = wrench_scale.asDiagonal() * own * to_scaled.cwiseInverse().asDiagonal();
  const Index n = size();
  origin_by_balance_.resize(6, n);
  balance_by_origin_.resize(n, 6);
  for (Index k = 0; k < n; ++k) {
    const Index coordinate = free_[static_cast<std::size_t>(k)];
    origin_by_balance_.col(k).head<6>() =
        wrench_scale.cwiseProduct(by_x_.col(coordinate).head<6>()) / unit_[k];
    balance_by_origin_.row(k).head<6>() =
        by_origin_.row(coordinate).head<6>().cwiseQuotient(to_scaled.transpose()) /
        (unit_[k] * scale_.stiffness);
  }
}

}  // namespace kinetostat::vjm
