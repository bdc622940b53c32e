#include "kinetostat/vjm/chain_equations.h"

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

ChainEquations::ChainEquations(const Chain& chain, VectorXd rest, const Scale& scale,
                               bool origin_moves)
    : chain_(chain),
      rest_(std::move(rest)),
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
  origin_ = origin.position();
  x_ = x;
  wrench_ = wrench;
  evaluate(chain_, x, kinematics_, origin);
}

void ChainEquations::set_node_loads(std::vector<std::pair<std::size_t, Vector6>> loads) {
  node_loads_ = std::move(loads);
}

std::vector<PointWrench> ChainEquations::point_wrenches() const {
  std::vector<PointWrench> all{at_end(chain_, kinematics_, wrench_)};
  for (const auto& [node, load] : node_loads_)
    all.push_back(at_node(chain_, kinematics_, node, load));
  return all;
}

VectorXd ChainEquations::gather_force(const VectorXd& full) const {
  return full(free_).cwiseQuotient(unit_) / scale_.stiffness;
}

VectorXd ChainEquations::unbalanced() const {
  VectorXd force = kinematics_.jacobian.transpose() * wrench_ - chain_.stiffness() * (x_ - rest_);
  for (const auto& [node, load] : node_loads_)
    add_generalised_force(chain_, kinematics_, at_node(chain_, kinematics_, node, load), force);
  for (const auto& [coordinate, law] : chain_.laws())
    force[coordinate] -= law->at(x_[coordinate]).force;
  return gather_force(force);
}

Vector6 ChainEquations::wrench_on_origin() const {
  Vector6 sum = Vector6::Zero();
  for (const PointWrench& load : point_wrenches()) {
    sum += load.wrench;
    sum.tail<3>() += (load.point - origin_).cross(load.wrench.head<3>());
  }
  return sum;
}

MatrixXd ChainEquations::jacobian() const {
  return scale_.twist().asDiagonal() * kinematics_.jacobian(Eigen::all, free_) *
         unit_.cwiseInverse().asDiagonal();
}

MatrixXd ChainEquations::energy_hessian() const {
  const MatrixXd lower = matrix_.bottomRightCorner(size(), size());
  return -0.5 * (lower + lower.transpose());
}

VectorXd ChainEquations::unbalanced_by_log_stiffness(const Spring& spring) const {
  VectorXd force = VectorXd::Zero(chain_.size());
  const Index n = spring.stiffness.rows();
  force.segment(spring.first, n) = -spring.stiffness * (x_ - rest_).segment(spring.first, n);
  return gather_force(force);
}

double ChainEquations::energy() const {
  const VectorXd deflection = x_ - rest_;
  double energy = 0.5 * deflection.dot(chain_.stiffness() * deflection);
  for (const auto& [coordinate, law] : chain_.laws()) energy += law->at(x_[coordinate]).energy;
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

void ChainEquations::linearise(bool factorise) {
  const Index n = size();
  hessian_ = -chain_.stiffness();
  add_wrench_hessian(chain_, kinematics_, at_end(chain_, kinematics_, wrench_), hessian_);
  for (const auto& [node, load] : node_loads_)
    add_wrench_hessian(chain_, kinematics_, at_node(chain_, kinematics_, node, load), hessian_);
  for (const auto& [coordinate, law] : chain_.laws())
    hessian_(coordinate, coordinate) -= law->at(x_[coordinate]).tangent;
  const VectorXd inverse_unit = unit_.cwiseInverse();
  matrix_.setZero(6 + n, 6 + n);
  matrix_.topRightCorner(6, n) = jacobian();
  matrix_.bottomLeftCorner(n, 6) = matrix_.topRightCorner(6, n).transpose();
  matrix_.bottomRightCorner(n, n) = inverse_unit.asDiagonal() * hessian_(free_, free_) *
                                    inverse_unit.asDiagonal() / scale_.stiffness;
  if (factorise) factor_.compute(matrix_);
  if (origin_moves_) linearise_origin();
}

// The origin's rotation acts like three joints nearer the base than all of the chain's; its moment
// is taken about axes that do not turn.
void ChainEquations::linearise_origin() {
  const Vector6 to_scaled = scale_.twist(), wrench_scale = scale_.wrench();
  Matrix6 end = Matrix6::Identity(), own = Matrix6::Zero();
  end.topRightCorner<3, 3>() = -spatial::skew(kinematics_.end.position() - origin_);
  MatrixXd by_x = MatrixXd::Zero(6, chain_.size()), by_origin = MatrixXd::Zero(chain_.size(), 6);
  for (const PointWrench& load : point_wrenches()) {
    const Vector3 force = load.wrench.head<3>(), moment = load.wrench.tail<3>();
    const Vector3 from_end = load.point - kinematics_.end.position();
    own.bottomRightCorner<3, 3>() += spatial::skew(force) * spatial::skew(load.point - origin_);
    for (Index j = 0; j < load.joints; ++j) {
      const Index k = chain_.joints()[static_cast<std::size_t>(j)].coordinate;
      const Vector3 w = kinematics_.joint_twists.col(j).tail<3>();
      const Vector3 v = kinematics_.joint_twists.col(j).head<3>() + w.cross(from_end);
      const Vector3 moment_change = v.cross(force);
      by_x.col(k).tail<3>() += moment_change;
      by_origin.row(k).tail<3>() += (moment_change + w.cross(moment)).transpose();
    }
  }
  const VectorXd inverse_unit = unit_.cwiseInverse();
  end_by_origin_ = to_scaled.asDiagonal() * end * to_scaled.cwiseInverse().asDiagonal();
  origin_by_origin_ = wrench_scale.asDiagonal() * own * to_scaled.cwiseInverse().asDiagonal();
  origin_by_balance_ =
      wrench_scale.asDiagonal() * by_x(Eigen::all, free_) * inverse_unit.asDiagonal();
  balance_by_origin_ = inverse_unit.asDiagonal() * by_origin(free_, Eigen::all) *
                       to_scaled.cwiseInverse().asDiagonal() / scale_.stiffness;
}

}  // namespace kinetostat::vjm
