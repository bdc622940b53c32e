#include "kinetostat/vjm/statics/equilibrium_system.h"

#include <cmath>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector6;

// First of the six rows of a body where all bodies have theirs.
Index first_row(int body) { return Index{6} * body; }

double stiffest(const Manipulator& manipulator, double length) {
  double largest = 0;
  for (const Chain& chain : manipulator.chains()) {
    const auto take = [&](Index k, double stiffness) {
      const bool turns = is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion);
      largest = std::max(largest, stiffness / (turns ? length * length : 1.0));
    };
    for (Index k = 0; k < chain.size(); ++k) take(k, chain.stiffness()(k, k));
    for (const auto& [k, law] : chain.laws())
      if (const auto* stop = dynamic_cast<const StopLaw*>(law.get())) take(k, stop->stiffness());
  }
  return largest > 0 ? largest : 1.0;
}

}  // namespace

double SystemVector::norm() const {
  double sum = bodies.squaredNorm();
  for (const Vector6& w : wrenches) sum += w.squaredNorm();
  for (const VectorXd& x : coordinates) sum += x.squaredNorm();
  return std::sqrt(sum);
}

EquilibriumSystem::EquilibriumSystem(const Manipulator& manipulator, const Posture& posture)
    : manipulator_(manipulator), posture_(posture) {
  ChainKinematics kinematics;
  double reach = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    evaluate(manipulator.chains()[c], posture.coordinates_of(manipulator.chains()[c], c),
             kinematics);
    reach = std::max(reach, kinematics.reach);
  }
  scale_.length = reach > 0 ? reach : 1.0;
  scale_.stiffness = stiffest(manipulator, scale_.length);
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    const int from = manipulator.span(c).from;
    chains_.emplace_back(chain, posture.commands(chain, c), scale_, from != Span::base);
    chains_.back().set(posture.body(from), posture.coordinates_of(chain, c), Vector6::Zero());
    chains_.back().hold_redundant();
    rigid_ |= !has_full_row_rank(chains_.back().jacobian());
  }
  by_end_.resize(chains_.size());
  by_origin_.resize(chains_.size());
  unit_.resize(chains_.size());
  chain_right_.resize(chains_.size());
  chain_solution_.resize(chains_.size());
}

SystemState EquilibriumSystem::relaxed_state() const {
  SystemState state;
  for (int body = 0; body < static_cast<int>(manipulator_.body_count()); ++body)
    state.bodies.push_back(posture_.body(body));
  state.wrenches.assign(chains_.size(), Vector6::Zero());
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Chain& chain = manipulator_.chains()[c];
    state.coordinates.push_back(posture_.coordinates_of(chain, c));
    // A drive starts where it leads its joint; without a spring it stays there.
    for (const TransmissionError& shift : chain.transmission_errors())
      state.coordinates[c][shift.coordinate] += shift.at(state.coordinates[c][shift.coordinate]);
  }
  return state;
}

void EquilibriumSystem::set(const SystemState& state, const Load& load) {
  state_ = state;
  load_ = load;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const int from = manipulator_.span(c).from;
    set_node_loads(c);
    chains_[c].set(from == Span::base ? Pose() : state.bodies[static_cast<std::size_t>(from)],
                   state.coordinates[c], state.wrenches[c]);
  }
}

// Masses under gravity and loads at nodes.
void EquilibriumSystem::set_node_loads(std::size_t c) {
  ChainEquations& chain = chains_[c];
  chain.clear_node_loads();
  const auto add = [&chain](std::size_t node, const spatial::Vector3& force,
                            const spatial::Vector3& moment) {
    Vector6 wrench;
    wrench << force, moment;
    if (!wrench.isZero(0)) chain.add_node_load(node, wrench);
  };
  for (const PointMass& mass : manipulator_.chains()[c].masses())
    add(mass.node, load_.gravity * mass.mass * manipulator_.gravity(), spatial::Vector3::Zero());
  for (const NodeLoad& node : load_.nodes)
    if (node.chain == c) add(node.node, node.force, node.moment);
}

Index EquilibriumSystem::free_bodies() const {
  return static_cast<Index>(manipulator_.body_count()) - (held_ ? 1 : 0);
}

Index EquilibriumSystem::row_of(int body) const {
  if (body == Span::base) return -1;
  return first_row(body - (held_ ? 1 : 0));
}

Matrix6 EquilibriumSystem::load_matrix() const {
  return scale_.wrench().asDiagonal() * load_.derivative(state_.bodies[0]) *
         scale_.twist().cwiseInverse().asDiagonal();
}

void EquilibriumSystem::linearise(bool platform_held) {
  held_ = platform_held;
  if (one_dense_matrix()) {
    build_dense(newton_matrix_);
    factor_.compute(newton_matrix_);
  } else {
    factorise_by_chains();
  }
}

void EquilibriumSystem::linearise_by_chains() {
  held_ = false;
  factorise_by_chains();
}

// Adds a chain, its own unknowns eliminated, to the balance of the bodies.
void EquilibriumSystem::add_chain_to_bodies(std::size_t c, MatrixXd& matrix, Index to,
                                            Index from) const {
  const Index n = chains_[c].size();
  if (to >= 0) matrix.block<6, 6>(to, to) += by_end_[c].topRows<6>();
  if (from < 0) return;
  const ChainEquations& chain = chains_[c];
  const auto on_origin = [&](const MatrixXd& response) {
    Matrix6 wrench = chain.end_by_origin().transpose() * response.topLeftCorner<6, 6>();
    wrench.noalias() += chain.origin_by_balance() * response.bottomRows(n);
    return wrench;
  };
  matrix.block<6, 6>(from, from) -= on_origin(by_origin_[c]) + chain.origin_by_origin();
  if (to < 0) return;
  matrix.block<6, 6>(to, from) += by_origin_[c].topRows<6>();
  matrix.block<6, 6>(from, to) -= on_origin(by_end_[c]);
}

void EquilibriumSystem::factorise_by_chains() {
  newton_matrix_.setZero(6 * free_bodies(), 6 * free_bodies());
  if (!held_) newton_matrix_.topLeftCorner<6, 6>() = -load_matrix();
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    ChainEquations& chain = chains_[c];
    chain.linearise(true);
    const Index to = row_of(manipulator_.span(c).to), from = row_of(manipulator_.span(c).from);
    if (to < 0 && from < 0) continue;
    unit_[c].setZero(6 + chain.size(), 6);
    unit_[c].topRows<6>().setIdentity();
    chain.factor().solve(unit_[c], by_end_[c], nullptr);
    if (chain.origin_moves()) {
      unit_[c].topRows<6>() = -chain.end_by_origin();
      unit_[c].bottomRows(chain.size()) = -chain.balance_by_origin();
      for (const Index k : chain.held()) unit_[c].row(6 + k).setZero();
      chain.factor().solve(unit_[c], by_origin_[c], nullptr);
    }
    add_chain_to_bodies(c, newton_matrix_, to, from);
  }
  factor_.compute(newton_matrix_);
}

MatrixXd EquilibriumSystem::dense_matrix() {
  MatrixXd matrix;
  build_dense(matrix);
  return matrix;
}

// Rows: balance of the bodies, then gap and balance of each chain; columns: t_b, then F_i, x_i.
void EquilibriumSystem::build_dense(MatrixXd& matrix) {
  Index size = 6 * free_bodies();
  for (ChainEquations& chain : chains_) {
    chain.linearise(false);
    size += chain.matrix().rows();
  }
  matrix.setZero(size, size);
  if (!held_) matrix.topLeftCorner<6, 6>() = -load_matrix();
  Index at = 6 * free_bodies();
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const ChainEquations& chain = chains_[c];
    const Index n = chain.size();
    matrix.block(at, at, 6 + n, 6 + n) = chain.matrix();
    const Index to = row_of(manipulator_.span(c).to), from = row_of(manipulator_.span(c).from);
    if (to >= 0) {
      matrix.block(to, at, 6, 6).setIdentity();
      matrix.block(at, to, 6, 6) = -Matrix6::Identity();
    }
    if (from >= 0) {
      matrix.block(from, at, 6, 6) = -chain.end_by_origin().transpose();
      matrix.block(from, at + 6, 6, n) = -chain.origin_by_balance();
      matrix.block<6, 6>(from, from) -= chain.origin_by_origin();
      matrix.block(at, from, 6, 6) = chain.end_by_origin();
      matrix.block(at + 6, from, n, 6) = chain.balance_by_origin();
      for (const Index k : chain.held()) matrix.row(at + 6 + k).segment<6>(from).setZero();
    }
    at += 6 + n;
  }
}

SystemVector EquilibriumSystem::zero() const {
  SystemVector v;
  make_zero(v);
  return v;
}

void EquilibriumSystem::make_zero(SystemVector& v) const {
  v.bodies.setZero(6 * static_cast<Index>(manipulator_.body_count()));
  v.wrenches.assign(chains_.size(), Vector6::Zero());
  v.coordinates.resize(chains_.size());
  for (std::size_t c = 0; c < chains_.size(); ++c) v.coordinates[c].setZero(chains_[c].size());
}

Vector6 EquilibriumSystem::platform_wrench() const {
  Vector6 sum = Vector6::Zero();
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    if (manipulator_.span(c).to == Span::platform) sum += state_.wrenches[c];
    if (manipulator_.span(c).from == Span::platform) sum -= chains_[c].wrench_on_origin();
  }
  return sum;
}

SystemVector EquilibriumSystem::newton_right_hand_side() const {
  SystemVector right;
  newton_right_hand_side(right);
  return right;
}

void EquilibriumSystem::newton_right_hand_side(SystemVector& right) const {
  make_zero(right);
  right.bodies.head<6>() = load_.at_reference_point(state_.bodies[0]);
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Span& span = manipulator_.span(c);
    right.bodies.segment<6>(first_row(span.to)) -= state_.wrenches[c];
    if (span.from != Span::base)
      right.bodies.segment<6>(first_row(span.from)) += chains_[c].wrench_on_origin();
    right.wrenches[c] = scale_.twist().cwiseProduct(spatial::pose_difference(
        chains_[c].end(), state_.bodies[static_cast<std::size_t>(span.to)]));
    chains_[c].unbalanced(right.coordinates[c]);
    right.coordinates[c] *= -1;
    for (const Index k : chains_[c].held()) right.coordinates[c][k] = 0;
  }
  const Vector6 force = scale_.wrench();
  for (Index b = 0; b < right.bodies.size(); b += 6)
    right.bodies.segment<6>(b).array() *= force.array();
  if (held_) right.bodies.head<6>().setZero();
}

SystemVector EquilibriumSystem::solve(const SystemVector& right) const {
  SystemVector solution;
  solve(right, solution);
  return solution;
}

void EquilibriumSystem::solve(const SystemVector& right, SystemVector& solution) const {
  solve_bodies(right, solution);
  for (std::size_t c = 0; c < chains_.size(); ++c) complete(c, right, solution);
}

void EquilibriumSystem::solve_bodies(const SystemVector& right, SystemVector& solution) const {
  if (one_dense_matrix()) {
    solve_dense(right, solution);
  } else {
    solve_bodies_by_chains(right, solution);
  }
}

void EquilibriumSystem::complete(std::size_t chain, const SystemVector& right,
                                 SystemVector& solution) const {
  if (!one_dense_matrix()) solve_chain(chain, right, solution);
}

VectorXd EquilibriumSystem::flat(const SystemVector& vector) const {
  VectorXd z;
  flat(vector, z);
  return z;
}

void EquilibriumSystem::flat(const SystemVector& vector, VectorXd& z) const {
  const Index bodies = 6 * free_bodies();
  Index size = bodies;
  for (const ChainEquations& chain : chains_) size += 6 + chain.size();
  z.resize(size);
  z.head(bodies) = vector.bodies.tail(bodies);
  Index at = bodies;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    z.segment<6>(at) = vector.wrenches[c];
    z.segment(at + 6, chains_[c].size()) = vector.coordinates[c];
    at += 6 + chains_[c].size();
  }
}

SystemVector EquilibriumSystem::from_flat(const VectorXd& z) const {
  SystemVector vector;
  from_flat(z, vector);
  return vector;
}

void EquilibriumSystem::from_flat(const VectorXd& z, SystemVector& vector) const {
  const Index bodies = 6 * free_bodies();
  make_zero(vector);
  vector.bodies.tail(bodies) = z.head(bodies);
  Index at = bodies;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    vector.wrenches[c] = z.segment<6>(at);
    vector.coordinates[c] = z.segment(at + 6, chains_[c].size());
    at += 6 + chains_[c].size();
  }
}

void EquilibriumSystem::solve_dense(const SystemVector& right, SystemVector& solution) const {
  flat(right, flat_right_);
  Index at = 6 * free_bodies();
  for (const ChainEquations& chain : chains_) {
    for (const Index k : chain.held()) flat_right_[at + 6 + k] = 0;
    at += 6 + chain.size();
  }
  flat_solution_.resize(flat_right_.size());
  factor_.solve(flat_right_, flat_solution_, &consistent_);
  from_flat(flat_solution_, solution);
}

// A chain's own equations, the bodies moved as the solution has them.
void EquilibriumSystem::solve_chain(std::size_t c, const SystemVector& right,
                                    SystemVector& solution) const {
  const ChainEquations& chain = chains_[c];
  const Index n = chain.size();
  VectorXd& r = chain_right_[c];
  r.resize(6 + n);
  r.head<6>() = right.wrenches[c];
  r.tail(n) = right.coordinates[c];
  const Span& span = manipulator_.span(c);
  r.head<6>() += solution.bodies.segment<6>(first_row(span.to));
  if (span.from != Span::base) {
    const Vector6 origin = solution.bodies.segment<6>(first_row(span.from));
    r.head<6>() -= chain.end_by_origin() * origin;
    r.tail(n).noalias() -= chain.balance_by_origin() * origin;
  }
  for (const Index k : chain.held()) r[6 + k] = 0;
  if (r.isZero(0)) {  // most chains, when one parameter of one of them changes
    chain_solution_[c].setZero(6 + n);
  } else {
    bool consistent = true;
    chain.factor().solve(r, chain_solution_[c], &consistent);
    consistent_ &= consistent;
  }
  solution.wrenches[c] = chain_solution_[c].head<6>();
  solution.coordinates[c] = chain_solution_[c].tail(n);
}

// Leaves in each chain what its own right-hand side does with its ends held.
void EquilibriumSystem::solve_bodies_by_chains(const SystemVector& right,
                                               SystemVector& solution) const {
  make_zero(solution);
  consistent_ = true;
  const Index bodies = 6 * free_bodies();
  if (bodies == 0) return;
  balance_ = right.bodies;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    solve_chain(c, right, solution);
    const Span& span = manipulator_.span(c);
    balance_.segment<6>(first_row(span.to)) -= solution.wrenches[c];
    if (span.from == Span::base) continue;
    auto on_origin = balance_.segment<6>(first_row(span.from));
    on_origin += chains_[c].end_by_origin().transpose() * solution.wrenches[c];
    on_origin.noalias() += chains_[c].origin_by_balance() * solution.coordinates[c];
  }
  bool consistent = true;
  flat_solution_.resize(bodies);
  factor_.solve(balance_.tail(bodies), flat_solution_, &consistent);
  solution.bodies.tail(bodies) = flat_solution_;
  consistent_ &= consistent;
}

SystemState EquilibriumSystem::moved(const SystemState& state, const SystemVector& correction,
                                     double factor) const {
  SystemState next;
  moved(state, correction, factor, next);
  return next;
}

void EquilibriumSystem::moved(const SystemState& state, const SystemVector& correction,
                              double factor, SystemState& next) const {
  next = state;
  for (std::size_t b = 0; b < state.bodies.size(); ++b)
    next.bodies[b] = spatial::displaced(
        state.bodies[b],
        factor *
            correction.bodies.segment<6>(static_cast<Index>(6 * b)).cwiseQuotient(scale_.twist()));
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    next.wrenches[c] += factor * correction.wrenches[c].cwiseQuotient(scale_.wrench());
    chains_[c].add_increment(correction.coordinates[c], factor, next.coordinates[c]);
  }
}

bool EquilibriumSystem::kinks(const SystemState& from, SystemState& to) const {
  bool any = false;
  for (std::size_t c = 0; c < chains_.size(); ++c)
    any |= chains_[c].kinks(from.coordinates[c], to.coordinates[c]);
  return any;
}

double EquilibriumSystem::wrench_norm(const SystemState& state) const {
  double sum = 0;
  for (const Vector6& wrench : state.wrenches)
    sum += scale_.wrench().cwiseProduct(wrench).squaredNorm();
  return std::sqrt(sum);
}

SystemVector EquilibriumSystem::difference(const SystemState& from, const SystemState& to) const {
  SystemVector change = zero();
  for (std::size_t b = 0; b < from.bodies.size(); ++b)
    change.bodies.segment<6>(static_cast<Index>(6 * b)) =
        scale_.twist().cwiseProduct(spatial::pose_difference(from.bodies[b], to.bodies[b]));
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    change.wrenches[c] = scale_.wrench().cwiseProduct(to.wrenches[c] - from.wrenches[c]);
    change.coordinates[c] = chains_[c].scaled_increment(to.coordinates[c] - from.coordinates[c]);
  }
  return change;
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

Matrix6 EquilibriumSystem::platform_stiffness() const {
  const Index inner = 6 * static_cast<Index>(manipulator_.body_count()) - 6;
  MatrixXd matrix = MatrixXd::Zero(6 + inner, 6 + inner);
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Span& span = manipulator_.span(c);
    add_chain_to_bodies(c, matrix, first_row(span.to),
                        span.from == Span::base ? -1 : first_row(span.from));
  }
  Matrix6 scaled = matrix.topLeftCorner<6, 6>();
  if (inner > 0) {
    RobustFactor followers;
    followers.compute(matrix.bottomRightCorner(inner, inner));
    scaled -= matrix.topRightCorner(6, inner) * followers.solve(matrix.bottomLeftCorner(inner, 6));
  }
  return scale_.wrench().cwiseInverse().asDiagonal() * scaled * scale_.twist().asDiagonal();
}

Matrix6 EquilibriumSystem::platform_compliance() const {
  Matrix6 compliance;
  bool all_consistent = true;
  for (int j = 0; j < 6; ++j) {
    SystemVector right = zero();
    right.bodies[j] = scale_.wrench()[j];
    compliance.col(j) = solve(right).bodies.head<6>().cwiseQuotient(scale_.twist());
    all_consistent &= consistent_;
  }
  consistent_ = all_consistent;
  return compliance;
}

EnergyHessian EquilibriumSystem::chain_energy_hessian(std::size_t c) const {
  return {chains_[c].energy_hessian(), null_space(chains_[c].jacobian()),
          chains_[c].energy_rounding()};
}

namespace {

// Rows that tie the chains' ends to the bodies, and the second derivative of the energy, in
// [bodies; coordinates of all chains].
struct ConstrainedEnergy {
  MatrixXd constraint, hessian;
  VectorXd rounding;
};

ConstrainedEnergy constrained_energy(const Manipulator& manipulator,
                                     const std::vector<ChainEquations>& chains) {
  const Index bodies = 6 * static_cast<Index>(manipulator.body_count());
  Index size = bodies;
  for (const ChainEquations& chain : chains) size += chain.size();
  ConstrainedEnergy e{MatrixXd::Zero(static_cast<Index>(6 * chains.size()), size),
                      MatrixXd::Zero(size, size), VectorXd::Zero(size)};
  Index at = bodies;
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const auto row = static_cast<Index>(6 * c);
    const Span& span = manipulator.span(c);
    const Index n = chains[c].size();
    e.constraint.block<6, 6>(row, first_row(span.to)) = -Matrix6::Identity();
    e.constraint.block(row, at, 6, n) = chains[c].jacobian();
    e.hessian.block(at, at, n, n) = chains[c].energy_hessian();
    e.rounding.segment(at, n) = chains[c].energy_rounding();
    if (span.from != Span::base) {
      e.constraint.block<6, 6>(row, first_row(span.from)) = chains[c].end_by_origin();
      e.hessian.block(at, first_row(span.from), n, 6) -= chains[c].balance_by_origin();
      e.hessian.block(first_row(span.from), at, 6, n) -= chains[c].origin_by_balance();
      e.hessian.block<6, 6>(first_row(span.from), first_row(span.from)) -=
          chains[c].origin_by_origin();
    }
    at += n;
  }
  return e;
}

}  // namespace

EnergyHessian EquilibriumSystem::energy_hessian(bool platform_held) const {
  ConstrainedEnergy e = constrained_energy(manipulator_, chains_);
  e.hessian.topLeftCorner<6, 6>() -= load_matrix();
  const Index first = platform_held ? 6 : 0, size = e.hessian.rows() - first;
  const MatrixXd hessian = e.hessian.bottomRightCorner(size, size);
  return {0.5 * (hessian + hessian.transpose()), null_space(e.constraint.rightCols(size)),
          e.rounding.tail(size)};
}

SystemVector EquilibriumSystem::motion(const VectorXd& bodies_and_coordinates) const {
  SystemVector motion = zero();
  Index at = bodies_and_coordinates.size();
  for (std::size_t c = chains_.size(); c-- > 0;) {
    at -= chains_[c].size();
    motion.coordinates[c] = bodies_and_coordinates.segment(at, chains_[c].size());
  }
  motion.bodies.tail(at) = bodies_and_coordinates.head(at);
  return motion;
}

Matrix6X EquilibriumSystem::motions_without_energy() const {
  const ConstrainedEnergy e = constrained_energy(manipulator_, chains_);
  MatrixXd rows(e.constraint.rows() + e.hessian.rows(), e.hessian.cols());
  rows << e.constraint, e.hessian;
  const MatrixXd null = null_space(rows, 1e-11).topRows<6>();
  if (null.cols() == 0) return Matrix6X(6, 0);
  return scale_.twist().cwiseInverse().asDiagonal() * spatial::range_of(null, 1e-9);
}

}  // namespace kinetostat::vjm
