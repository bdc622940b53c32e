#include "kinetostat/vjm/equilibrium_system.h"

#include <cmath>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

double stiffest(const Manipulator& manipulator, double length) {
  double largest = 0;
  for (const Chain& chain : manipulator.chains())
    for (Index k = 0; k < chain.size(); ++k) {
      const bool turns = is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion);
      largest = std::max(largest, chain.stiffness()(k, k) / (turns ? length * length : 1.0));
    }
  return largest > 0 ? largest : 1.0;
}

}  // namespace

Vector6 Scale::twist() const {
  Vector6 s = Vector6::Ones();
  s.tail<3>().setConstant(length);
  return s;
}

Vector6 Scale::wrench() const { return twist().cwiseInverse() / stiffness; }

Vector6 Load::at_reference_point(const Pose& platform) const {
  Vector6 wrench;
  wrench << force, moment + (platform.rotation() * point_on_platform).cross(force);
  return wrench;
}

Matrix6 Load::derivative(const Pose& platform) const {
  // d((dphi x r) x f) with r = R * point_on_platform
  Matrix6 d = Matrix6::Zero();
  d.bottomRightCorner<3, 3>() =
      spatial::skew(force) * spatial::skew(platform.rotation() * point_on_platform);
  return d;
}

double SystemVector::norm() const {
  double sum = platform.squaredNorm();
  for (const Vector6& w : wrenches) sum += w.squaredNorm();
  for (const VectorXd& x : coordinates) sum += x.squaredNorm();
  return std::sqrt(sum);
}

void RobustFactor::compute(const MatrixXd& matrix) {
  lu_.compute(matrix);
  const auto pivots = lu_.matrixLU().diagonal().cwiseAbs();
  singular_ = !(pivots.minCoeff() > 1e-13 * pivots.maxCoeff());
  if (!singular_) return;
  matrix_ = matrix;
  orthogonal_.setThreshold(1e-11);
  orthogonal_.compute(matrix);
}

MatrixXd RobustFactor::solve(const MatrixXd& right, bool* consistent) const {
  if (consistent) *consistent = true;
  if (!singular_) return lu_.solve(right);
  MatrixXd solution = orthogonal_.solve(right);
  if (consistent) *consistent = (matrix_ * solution - right).norm() <= 1e-8 * right.norm();
  return solution;
}

MatrixXd null_space(const MatrixXd& matrix, double tolerance) {
  if (matrix.size() == 0) return MatrixXd::Identity(matrix.cols(), matrix.cols());
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(tolerance);
  qr.compute(matrix.transpose());
  const MatrixXd q = qr.householderQ() * MatrixXd::Identity(matrix.cols(), matrix.cols());
  return q.rightCols(matrix.cols() - qr.rank());
}

ChainEquations::ChainEquations(const Chain& chain, VectorXd rest, const Scale& scale)
    : chain_(chain), rest_(std::move(rest)), scale_(scale), free_(chain.free_coordinates()) {
  unit_.resize(size());
  for (Index k = 0; k < size(); ++k) {
    const auto c = static_cast<std::size_t>(free_[static_cast<std::size_t>(k)]);
    unit_[k] = is_rotation(chain.coordinates()[c].motion) ? scale.length : 1.0;
  }
}

void ChainEquations::set(const VectorXd& x, const Vector6& wrench) {
  x_ = x;
  wrench_ = wrench;
  evaluate(chain_, x, kinematics_);
}

VectorXd ChainEquations::gather_force(const VectorXd& full) const {
  return full(free_).cwiseQuotient(unit_) / scale_.stiffness;
}

VectorXd ChainEquations::unbalanced() const {
  return gather_force(kinematics_.jacobian.transpose() * wrench_ -
                      chain_.stiffness() * (x_ - rest_));
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
  return 0.5 * deflection.dot(chain_.stiffness() * deflection);
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
  wrench_hessian(chain_, kinematics_, wrench_, hessian_);
  const VectorXd inverse_unit = unit_.cwiseInverse();
  matrix_.setZero(6 + n, 6 + n);
  matrix_.topRightCorner(6, n) = jacobian();
  matrix_.bottomLeftCorner(n, 6) = matrix_.topRightCorner(6, n).transpose();
  matrix_.bottomRightCorner(n, n) = inverse_unit.asDiagonal() *
                                    (hessian_ - chain_.stiffness())(free_, free_) *
                                    inverse_unit.asDiagonal() / scale_.stiffness;
  if (factorise) factor_.compute(matrix_);
}

EquilibriumSystem::EquilibriumSystem(const Manipulator& manipulator, const Posture& posture)
    : manipulator_(manipulator), posture_(posture) {
  ChainKinematics kinematics;
  double reach = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    evaluate(manipulator.chains()[c], posture.coordinates[c], kinematics);
    reach = std::max(reach, kinematics.reach);
  }
  scale_.length = reach > 0 ? reach : 1.0;
  scale_.stiffness = stiffest(manipulator, scale_.length);
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    chains_.emplace_back(chain, posture.rest(chain, c), scale_);
    chains_.back().set(posture.coordinates[c], Vector6::Zero());
    const MatrixXd jacobian = chains_.back().jacobian();
    rigid_ |= jacobian.cols() < 6 || null_space(jacobian.transpose()).cols() > 0;
  }
}

SystemState EquilibriumSystem::relaxed_state() const {
  SystemState state;
  state.platform = posture_.platform;
  state.wrenches.assign(chains_.size(), Vector6::Zero());
  state.coordinates = posture_.coordinates;
  // Preloaded passive springs start at the posture too: their force is part of the first residual.
  return state;
}

void EquilibriumSystem::set(const SystemState& state, const Load& load) {
  state_ = state;
  load_ = load;
  for (std::size_t c = 0; c < chains_.size(); ++c)
    chains_[c].set(state.coordinates[c], state.wrenches[c]);
}

void EquilibriumSystem::linearise(bool platform_held) {
  held_ = platform_held;
  if (!held_ && one_dense_matrix()) {
    linearise_dense();
  } else {
    linearise_by_chains();
  }
}

void EquilibriumSystem::linearise_by_chains() {
  Matrix6 sum = Matrix6::Zero();
  for (ChainEquations& chain : chains_) {
    chain.linearise(true);
    if (held_) continue;
    MatrixXd unit = MatrixXd::Zero(6 + chain.size(), 6);
    unit.topRows<6>().setIdentity();
    sum += chain.factor().solve(unit).topRows<6>();
  }
  if (held_) return;
  const Matrix6 load = scale_.wrench().asDiagonal() * load_.derivative(state_.platform) *
                       scale_.twist().cwiseInverse().asDiagonal();
  platform_factor_.compute(sum - load);
}

// Rows: gap of each chain, balance of each chain, balance of the platform; columns: t, then F_i,
// x_i.
void EquilibriumSystem::linearise_dense() {
  Index size = 6;
  for (ChainEquations& chain : chains_) {
    chain.linearise(false);
    size += chain.matrix().rows();
  }
  MatrixXd matrix = MatrixXd::Zero(size, size);
  matrix.topLeftCorner<6, 6>() =
      -(scale_.wrench().asDiagonal() * load_.derivative(state_.platform) *
        scale_.twist().cwiseInverse().asDiagonal());
  Index at = 6;
  for (const ChainEquations& chain : chains_) {
    matrix.block(0, at, 6, 6).setIdentity();
    matrix.block(at, 0, 6, 6) = -Matrix6::Identity();
    matrix.block(at, at, chain.matrix().rows(), chain.matrix().cols()) = chain.matrix();
    at += chain.matrix().rows();
  }
  platform_factor_.compute(matrix);
}

SystemVector EquilibriumSystem::zero() const {
  SystemVector v;
  v.wrenches.assign(chains_.size(), Vector6::Zero());
  for (const ChainEquations& chain : chains_) v.coordinates.push_back(VectorXd::Zero(chain.size()));
  return v;
}

SystemVector EquilibriumSystem::newton_right_hand_side() const {
  SystemVector right = zero();
  right.platform = load_.at_reference_point(state_.platform);
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    right.platform -= state_.wrenches[c];
    right.wrenches[c] =
        scale_.twist().cwiseProduct(spatial::pose_difference(chains_[c].end(), state_.platform));
    right.coordinates[c] = -chains_[c].unbalanced();
  }
  right.platform = scale_.wrench().cwiseProduct(right.platform);
  if (held_) right.platform.setZero();
  return right;
}

SystemVector EquilibriumSystem::solve(const SystemVector& right) const {
  return !held_ && one_dense_matrix() ? solve_dense(right) : solve_by_chains(right);
}

SystemVector EquilibriumSystem::solve_dense(const SystemVector& right) const {
  Index size = 6;
  for (const ChainEquations& chain : chains_) size += 6 + chain.size();
  VectorXd r(size);
  r.head<6>() = right.platform;
  Index at = 6;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    r.segment<6>(at) = right.wrenches[c];
    r.segment(at + 6, chains_[c].size()) = right.coordinates[c];
    at += 6 + chains_[c].size();
  }
  const VectorXd z = platform_factor_.solve(r, &consistent_);
  SystemVector solution = zero();
  solution.platform = z.head<6>();
  at = 6;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    solution.wrenches[c] = z.segment<6>(at);
    solution.coordinates[c] = z.segment(at + 6, chains_[c].size());
    at += 6 + chains_[c].size();
  }
  return solution;
}

SystemVector EquilibriumSystem::solve_by_chains(const SystemVector& right) const {
  SystemVector solution = zero();
  consistent_ = true;
  const auto solve_chain = [&](std::size_t c, const Vector6& gap) {
    VectorXd r(6 + chains_[c].size());
    r << gap, right.coordinates[c];
    bool consistent = true;
    const VectorXd z = chains_[c].factor().solve(r, &consistent);
    consistent_ &= consistent;
    solution.wrenches[c] = z.head<6>();
    solution.coordinates[c] = z.tail(chains_[c].size());
  };
  if (!held_) {
    Vector6 balance = right.platform;
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      solve_chain(c, right.wrenches[c]);
      balance -= solution.wrenches[c];
    }
    bool consistent = true;
    solution.platform = platform_factor_.solve(balance, &consistent);
    consistent_ &= consistent;
  }
  for (std::size_t c = 0; c < chains_.size(); ++c)
    solve_chain(c, right.wrenches[c] + solution.platform);
  return solution;
}

SystemState EquilibriumSystem::moved(const SystemState& state, const SystemVector& correction,
                                     double factor) const {
  SystemState next = state;
  next.platform = spatial::displaced(state.platform,
                                     factor * correction.platform.cwiseQuotient(scale_.twist()));
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    next.wrenches[c] += factor * correction.wrenches[c].cwiseQuotient(scale_.wrench());
    next.coordinates[c] += factor * chains_[c].full_increment(correction.coordinates[c]);
  }
  return next;
}

Matrix6 EquilibriumSystem::chain_stiffness(std::size_t c) const {
  MatrixXd unit = MatrixXd::Zero(6 + chains_[c].size(), 6);
  unit.topRows<6>().setIdentity();
  const Matrix6 scaled = chains_[c].factor().solve(unit).topRows<6>();
  return scale_.wrench().cwiseInverse().asDiagonal() * scaled * scale_.twist().asDiagonal();
}

MatrixXd EquilibriumSystem::chain_motion(std::size_t c) const {
  MatrixXd unit = MatrixXd::Zero(6 + chains_[c].size(), 6);
  unit.topRows<6>() = Matrix6(scale_.twist().asDiagonal());
  const MatrixXd scaled = chains_[c].factor().solve(unit).bottomRows(chains_[c].size());
  MatrixXd motion(manipulator_.chains()[c].size(), 6);
  for (Index j = 0; j < 6; ++j) motion.col(j) = chains_[c].full_increment(scaled.col(j));
  return motion;
}

Matrix6 EquilibriumSystem::platform_compliance() {
  Matrix6 compliance;
  bool all_consistent = true;
  for (int j = 0; j < 6; ++j) {
    SystemVector right = zero();
    right.platform[j] = scale_.wrench()[j];
    compliance.col(j) = solve(right).platform.cwiseQuotient(scale_.twist());
    all_consistent &= consistent_;
  }
  consistent_ = all_consistent;
  return compliance;
}

MatrixXd EquilibriumSystem::held_energy_hessian(std::size_t c) const {
  const MatrixXd basis = null_space(chains_[c].jacobian());
  return basis.transpose() * chains_[c].energy_hessian() * basis;
}

MatrixXd EquilibriumSystem::free_energy_hessian() const {
  Index size = 6;
  for (const ChainEquations& chain : chains_) size += chain.size();
  const auto m = static_cast<Index>(6 * chains_.size());
  MatrixXd constraint = MatrixXd::Zero(m, size), hessian = MatrixXd::Zero(size, size);
  const Matrix6 load = scale_.wrench().asDiagonal() * load_.derivative(state_.platform) *
                       scale_.twist().cwiseInverse().asDiagonal();
  hessian.topLeftCorner<6, 6>() = -0.5 * (load + load.transpose());
  Index at = 6;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const auto row = static_cast<Index>(6 * c);
    constraint.block<6, 6>(row, 0) = -Matrix6::Identity();
    constraint.block(row, at, 6, chains_[c].size()) = chains_[c].jacobian();
    hessian.block(at, at, chains_[c].size(), chains_[c].size()) = chains_[c].energy_hessian();
    at += chains_[c].size();
  }
  const MatrixXd basis = null_space(constraint);
  return basis.transpose() * hessian * basis;
}

}  // namespace kinetostat::vjm
