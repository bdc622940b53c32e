#include "kinetostat/vjm/statics/chainwise_factor.h"

#include <cassert>

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;
using spatial::Vector6;

ChainwiseFactor::ChainwiseFactor(const EquilibriumResiduals& at, bool platform_held)
    : tangent_(at),
      held_(platform_held),
      chains_(tangent_.chains().size()),
      scratch_(chains_.size()) {
  factorise();
}

void ChainwiseFactor::renew(const EquilibriumResiduals& at) {
  tangent_.renew(at);
  factorise();
}

void ChainwiseFactor::factorise() {
  const EquilibriumSystem& system = tangent_.system();
  const Index bodies = system.body_rows(held_);
  matrix_.setZero(bodies, bodies);
  if (!held_) matrix_.topLeftCorner<6, 6>() = -tangent_.load_matrix();
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    chains_[c].factor.compute(tangent_.chains()[c].matrix());
    const Span& span = system.manipulator().span(c);
    const Index to = system.row_of(span.to, held_), from = system.row_of(span.from, held_);
    if (to < 0 && from < 0) continue;
    respond(c);
    add_to_bodies(c, matrix_, to, from);
  }
  factor_.compute(matrix_);
}

// Of one chain, to unit displacements of the bodies at its ends.
void ChainwiseFactor::respond(std::size_t c) {
  const ChainTangent& tangent = tangent_.chains()[c];
  OfChain& chain = chains_[c];
  chain.unit.setZero(6 + tangent.size(), 6);
  chain.unit.topRows<6>().setIdentity();
  chain.factor.solve(chain.unit, chain.by_end, nullptr);
  if (!tangent.equations().origin_moves()) return;
  chain.unit.topRows<6>() = -tangent.end_by_origin();
  chain.unit.bottomRows(tangent.size()) = -tangent.balance_by_origin();
  for (const Index k : tangent.held()) chain.unit.row(6 + k).setZero();
  chain.factor.solve(chain.unit, chain.by_origin, nullptr);
}

// Adds a chain, its own unknowns eliminated, to the balance of the bodies.
void ChainwiseFactor::add_to_bodies(std::size_t c, MatrixXd& matrix, Index to, Index from) const {
  const MatrixXd& by_end = chains_[c].by_end;
  const MatrixXd& by_origin = chains_[c].by_origin;
  if (to >= 0) matrix.block<6, 6>(to, to) += by_end.topRows<6>();
  if (from < 0) return;
  const ChainTangent& chain = tangent_.chains()[c];
  const auto on_origin = [&](const MatrixXd& response) {
    Matrix6 wrench = chain.end_by_origin().transpose() * response.topLeftCorner<6, 6>();
    wrench.noalias() += chain.origin_by_balance() * response.bottomRows(chain.size());
    return wrench;
  };
  matrix.block<6, 6>(from, from) -= on_origin(by_origin) + chain.origin_by_origin();
  if (to < 0) return;
  matrix.block<6, 6>(to, from) += by_origin.topRows<6>();
  matrix.block<6, 6>(from, to) -= on_origin(by_end);
}

bool ChainwiseFactor::solve(const SystemVector& right, SystemVector& solution) const {
  bool consistent = solve_bodies(right, solution);
  for (std::size_t c = 0; c < chains_.size(); ++c) consistent &= complete(c, right, solution);
  return consistent;
}

// Leaves in each chain what its own right-hand side does with its ends held.
bool ChainwiseFactor::solve_bodies(const SystemVector& right, SystemVector& solution) const {
  const EquilibriumSystem& system = tangent_.system();
  system.make_zero(solution);
  const Index bodies = system.body_rows(held_);
  if (bodies == 0) return true;
  bool consistent = true;
  balance_ = right.bodies;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    consistent &= complete(c, right, solution);
    const ChainTangent& chain = tangent_.chains()[c];
    const Span& span = system.manipulator().span(c);
    balance_.segment<6>(system.row_of(span.to, false)) -= solution.wrenches[c];
    if (span.from == Span::base) continue;
    auto on_origin = balance_.segment<6>(system.row_of(span.from, false));
    on_origin += chain.end_by_origin().transpose() * solution.wrenches[c];
    on_origin.noalias() += chain.origin_by_balance() * solution.coordinates[c];
  }
  bool balanced = true;
  bodies_.resize(bodies);
  factor_.solve(balance_.tail(bodies), bodies_, &balanced);
  solution.bodies.tail(bodies) = bodies_;
  return consistent && balanced;
}

// A chain's own equations, the bodies moved as the solution has them.
bool ChainwiseFactor::complete(std::size_t c, const SystemVector& right,
                               SystemVector& solution) const {
  const EquilibriumSystem& system = tangent_.system();
  const ChainTangent& chain = tangent_.chains()[c];
  const Index n = chain.size();
  VectorXd& r = scratch_[c].right;
  r.resize(6 + n);
  r.head<6>() = right.wrenches[c];
  r.tail(n) = right.coordinates[c];
  const Span& span = system.manipulator().span(c);
  r.head<6>() += solution.bodies.segment<6>(system.row_of(span.to, false));
  if (span.from != Span::base) {
    const Vector6 origin = solution.bodies.segment<6>(system.row_of(span.from, false));
    r.head<6>() -= chain.end_by_origin() * origin;
    r.tail(n).noalias() -= chain.balance_by_origin() * origin;
  }
  for (const Index k : chain.held()) r[6 + k] = 0;
  bool consistent = true;
  VectorXd& own = scratch_[c].solution;
  if (r.isZero(0)) {  // most chains, when one parameter of one of them changes
    own.setZero(6 + n);
  } else {
    chains_[c].factor.solve(r, own, &consistent);
  }
  solution.wrenches[c] = own.head<6>();
  solution.coordinates[c] = own.tail(n);
  return consistent;
}

Matrix6 ChainwiseFactor::chain_stiffness(std::size_t c) const {
  const Scale& scale = tangent_.system().scale();
  MatrixXd unit = MatrixXd::Zero(6 + tangent_.chains()[c].size(), 6);
  unit.topRows<6>().setIdentity();
  const Matrix6 scaled = chains_[c].factor.solve(unit).topRows<6>();
  return scale.wrench().cwiseInverse().asDiagonal() * scaled * scale.twist().asDiagonal();
}

MatrixXd ChainwiseFactor::chain_motion(std::size_t c) const {
  const ChainEquations& equations = tangent_.chains()[c].equations();
  MatrixXd unit = MatrixXd::Zero(6 + equations.size(), 6);
  unit.topRows<6>() = Matrix6(equations.scale().twist().asDiagonal());
  const MatrixXd scaled = chains_[c].factor.solve(unit).bottomRows(equations.size());
  MatrixXd motion(equations.chain().size(), 6);
  for (Index j = 0; j < 6; ++j) motion.col(j) = equations.full_increment(scaled.col(j));
  return motion;
}

Matrix6 ChainwiseFactor::platform_stiffness() const {
  assert(!held_);
  const EquilibriumSystem& system = tangent_.system();
  const Index inner = system.body_rows(false) - 6;
  MatrixXd matrix = MatrixXd::Zero(6 + inner, 6 + inner);
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Span& span = system.manipulator().span(c);
    add_to_bodies(c, matrix, system.row_of(span.to, false), system.row_of(span.from, false));
  }
  Matrix6 scaled = matrix.topLeftCorner<6, 6>();
  if (inner > 0) {
    RobustFactor followers;
    followers.compute(matrix.bottomRightCorner(inner, inner));
    scaled -= matrix.topRightCorner(6, inner) * followers.solve(matrix.bottomLeftCorner(inner, 6));
  }
  return system.scale().wrench().cwiseInverse().asDiagonal() * scaled *
         system.scale().twist().asDiagonal();
}

}  // namespace kinetostat::vjm
