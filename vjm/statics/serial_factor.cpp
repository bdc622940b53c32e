#include "kinetostat/vjm/statics/serial_factor.h"

namespace kinetostat::vjm {

using Eigen::Index;
using spatial::Vector6;

bool SerialFactor::can_factorise(const EquilibriumSystem& system, bool platform_held) {
  return !platform_held && system.chains().size() == 1 && system.manipulator().is_parallel() &&
         !system.has_rigid_directions();
}

SerialFactor::SerialFactor(const EquilibriumResiduals& at) : tangent_(at) { factorise(); }

void SerialFactor::renew(const EquilibriumResiduals& at) {
  tangent_.renew(at);
  factorise();
}

void SerialFactor::factorise() {
  const ChainTangent& chain = tangent_.chains()[0];
  const Index n = chain.size();
  matrix_ = chain.matrix().bottomRightCorner(n, n);
  if (!tangent_.load_matrix().isZero(0)) {
    const auto jacobian = chain.matrix().topRows<6>().rightCols(n);
    loaded_.noalias() = tangent_.load_matrix() * jacobian;
    matrix_.noalias() += jacobian.transpose() * loaded_;
  }
  factor_.compute(matrix_);
  body_motion_.resize(0, 6);
}

// What is left of a right-hand side when body and gap are eliminated.
void SerialFactor::find_right(const SystemVector& right) const {
  const ChainTangent& chain = tangent_.chains()[0];
  right_ = right.coordinates[0];
  for (const Index k : chain.held()) right_[k] = 0;
  const Vector6 force = right.bodies.head<6>() - tangent_.load_matrix() * right.wrenches[0];
  right_.noalias() -= chain.matrix().topRows<6>().rightCols(chain.size()).transpose() * force;
}

void SerialFactor::prepare_bodies() const {
  if (factor_.singular()) return;
  const ChainTangent& chain = tangent_.chains()[0];
  body_motion_ = chain.matrix().topRows<6>().rightCols(chain.size()).transpose();
  factor_.solve_transposed_in_place(body_motion_);
}

bool SerialFactor::solve_bodies(const SystemVector& right, SystemVector& solution) const {
  if (body_motion_.rows() == 0) return solve(right, solution);
  find_right(right);
  solution.bodies.resize(6);
  solution.bodies.noalias() = body_motion_.transpose() * right_;
  solution.bodies.head<6>() -= right.wrenches[0];
  return true;
}

bool SerialFactor::solve(const SystemVector& right, SystemVector& solution) const {
  const ChainTangent& chain = tangent_.chains()[0];
  const Index n = chain.size();
  const auto jacobian = chain.matrix().topRows<6>().rightCols(n);
  const Vector6 body = right.bodies.head<6>(), gap = right.wrenches[0];
  tangent_.system().make_zero(solution);
  find_right(right);
  bool consistent = true;
  factor_.solve(right_, solution.coordinates[0], &consistent);
  solution.bodies.head<6>() = jacobian * solution.coordinates[0] - gap;
  solution.wrenches[0] = body + tangent_.load_matrix() * solution.bodies.head<6>();
  return consistent;
}

}  // namespace kinetostat::vjm
