#include "kinetostat/vjm/statics/equilibrium_tangent.h"

#include <array>

#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/vjm/chain/robust_factor.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Matrix6;

EquilibriumTangent::EquilibriumTangent(const EquilibriumResiduals& at)
    : system_(&at.system()), load_matrix_(at.load_matrix()) {
  chains_.reserve(at.chains().size());
  for (const ChainResiduals& chain : at.chains()) chains_.emplace_back(chain);
  find_elastic_bodies(at);
}

void EquilibriumTangent::renew(const EquilibriumResiduals& at) {
  load_matrix_ = at.load_matrix();
  for (std::size_t c = 0; c < chains_.size(); ++c) chains_[c].renew(at.chains()[c]);
  find_elastic_bodies(at);
}

void EquilibriumTangent::find_elastic_bodies(const EquilibriumResiduals& at) {
  const Scale& scale = system_->scale();
  elastic_bodies_.clear();
  for (const ElasticBody& body : system_->manipulator().elastic_bodies()) {
    VectorXd unit(body.stiffness.rows());
    for (std::size_t i = 0; i < body.chains.size(); ++i)
      unit.segment<6>(static_cast<Index>(6 * i)) =
          system_->chains()[body.chains[i]].unit().cwiseInverse();
    const ElasticTangent tangent = at.tangent(body);
    const double moment = scale.length * scale.stiffness;
    elastic_bodies_.push_back(
        {unit.asDiagonal() * (body.stiffness / scale.stiffness) * unit.asDiagonal(),
         (unit.asDiagonal() * tangent.by_turn).transpose() / moment,
         tangent.moment / (scale.length * moment)});
  }
}

EquilibriumTangent::Places EquilibriumTangent::places_of(const ElasticBody& body,
                                                         const std::vector<Index>& first,
                                                         bool platform_held) const {
  Places places;
  for (const std::size_t c : body.chains)
    for (Index k = 0; k < 6; ++k) places.coordinates.push_back(first[c] + k);
  const Index origin = system_->row_of(body.origin, platform_held);
  if (origin >= 0) places.turn = origin + 3;
  return places;
}

MatrixXd EquilibriumTangent::matrix(bool platform_held) const {
  MatrixXd all;
  matrix(platform_held, all);
  return all;
}

namespace {

// Puts a chain at rows and columns `at`, its ends on the bodies at rows `to` and `from`.
void place(const ChainTangent& chain, Index at, Index to, Index from, MatrixXd& matrix) {
  const Index n = chain.size();
  matrix.block(at, at, 6 + n, 6 + n) = chain.matrix();
  if (to >= 0) {
    matrix.block(to, at, 6, 6).setIdentity();
    matrix.block(at, to, 6, 6) = -Matrix6::Identity();
  }
  if (from < 0) return;
  matrix.block(from, at, 6, 6) = -chain.end_by_origin().transpose();
  matrix.block(from, at + 6, 6, n) = -chain.origin_by_balance();
  matrix.block<6, 6>(from, from) -= chain.origin_by_origin();
  matrix.block(at, from, 6, 6) = chain.end_by_origin();
  matrix.block(at + 6, from, n, 6) = chain.balance_by_origin();
  for (const Index k : chain.held()) matrix.row(at + 6 + k).segment<6>(from).setZero();
}

}  // namespace

// Rows: balance of the bodies, then gap and balance of each chain; columns: t_b, then F_i, x_i.
void EquilibriumTangent::matrix(bool platform_held, MatrixXd& all) const {
  const Index bodies = system_->body_rows(platform_held);
  Index size = bodies;
  for (const ChainTangent& chain : chains_) size += chain.matrix().rows();
  all.setZero(size, size);
  if (!platform_held) all.topLeftCorner<6, 6>() = -load_matrix_;
  Index at = bodies;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Span& span = system_->manipulator().span(c);
    place(chains_[c], at, system_->row_of(span.to, platform_held),
          system_->row_of(span.from, platform_held), all);
    at += 6 + chains_[c].size();
  }
  add_elastic_bodies(platform_held, all);
}

void EquilibriumTangent::add_elastic_bodies(bool platform_held, MatrixXd& all) const {
  if (elastic_bodies_.empty()) return;
  std::vector<Index> first;  // coordinate of each chain
  Index at = system_->body_rows(platform_held);
  for (const ChainTangent& chain : chains_) {
    first.push_back(at + 6);
    at += 6 + chain.size();
  }
  for (std::size_t b = 0; b < elastic_bodies_.size(); ++b) {
    const OfElasticBody& body = elastic_bodies_[b];
    const auto [x, turn] =
        places_of(system_->manipulator().elastic_bodies()[b], first, platform_held);
    all(x, x) -= body.stiffness;
    if (turn < 0) continue;
    const std::array<Index, 3> r{turn, turn + 1, turn + 2};
    all(x, r) += body.by_turn.transpose();
    all(r, x) -= body.by_turn;
    all(r, r) -= body.moment;
  }
}

EnergyHessian EquilibriumTangent::chain_energy_hessian(std::size_t c) const {
  return {chains_[c].energy_hessian(), null_space(chains_[c].jacobian()),
          chains_[c].energy_rounding()};
}

namespace {

// Where the coordinates of the chains start behind the rows of the bodies.
std::vector<Index> first_coordinates(Index bodies, const std::vector<ChainTangent>& chains) {
  std::vector<Index> first;
  for (const ChainTangent& chain : chains) {
    first.push_back(bodies);
    bodies += chain.size();
  }
  return first;
}

// Rows that tie the chains' ends to the bodies, and the second derivative of the energy, in
// [bodies; coordinates of all chains].
struct ConstrainedEnergy {
  MatrixXd constraint, hessian;
  VectorXd rounding;
};

ConstrainedEnergy constrained_energy(const EquilibriumSystem& system,
                                     const std::vector<ChainTangent>& chains) {
  const Index bodies = system.body_rows(false);
  Index size = bodies;
  for (const ChainTangent& chain : chains) size += chain.size();
  ConstrainedEnergy e{MatrixXd::Zero(static_cast<Index>(6 * chains.size()), size),
                      MatrixXd::Zero(size, size), VectorXd::Zero(size)};
  Index at = bodies;
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const auto row = static_cast<Index>(6 * c);
    const Span& span = system.manipulator().span(c);
    const Index n = chains[c].size();
    e.constraint.block<6, 6>(row, system.row_of(span.to, false)) = -Matrix6::Identity();
    e.constraint.block(row, at, 6, n) = chains[c].jacobian();
    e.hessian.block(at, at, n, n) = chains[c].energy_hessian();
    e.rounding.segment(at, n) = chains[c].energy_rounding();
    if (span.from != Span::base) {
      const Index from = system.row_of(span.from, false);
      e.constraint.block<6, 6>(row, from) = chains[c].end_by_origin();
      e.hessian.block(at, from, n, 6) -= chains[c].balance_by_origin();
      e.hessian.block(from, at, 6, n) -= chains[c].origin_by_balance();
      e.hessian.block<6, 6>(from, from) -= chains[c].origin_by_origin();
    }
    at += n;
  }
  return e;
}

}  // namespace

void EquilibriumTangent::add_elastic_energy(MatrixXd& hessian) const {
  const std::vector<Index> first = first_coordinates(system_->body_rows(false), chains_);
  for (std::size_t b = 0; b < elastic_bodies_.size(); ++b) {
    const OfElasticBody& body = elastic_bodies_[b];
    const auto [x, turn] = places_of(system_->manipulator().elastic_bodies()[b], first, false);
    hessian(x, x) += body.stiffness;
    if (turn < 0) continue;
    const std::array<Index, 3> r{turn, turn + 1, turn + 2};
    hessian(x, r) -= body.by_turn.transpose();
    hessian(r, x) -= body.by_turn;
    hessian(r, r) -= body.moment;
  }
}

EnergyHessian EquilibriumTangent::energy_hessian(bool platform_held) const {
  ConstrainedEnergy e = constrained_energy(*system_, chains_);
  add_elastic_energy(e.hessian);
  e.hessian.topLeftCorner<6, 6>() -= load_matrix_;
  const Index first = platform_held ? 6 : 0, size = e.hessian.rows() - first;
  const MatrixXd hessian = e.hessian.bottomRightCorner(size, size);
  return {0.5 * (hessian + hessian.transpose()), null_space(e.constraint.rightCols(size)),
          e.rounding.tail(size)};
}

Matrix6X EquilibriumTangent::motions_without_energy() const {
  ConstrainedEnergy e = constrained_energy(*system_, chains_);
  add_elastic_energy(e.hessian);
  MatrixXd rows(e.constraint.rows() + e.hessian.rows(), e.hessian.cols());
  rows << e.constraint, e.hessian;
  const MatrixXd null = null_space(rows, 1e-11).topRows<6>();
  if (null.cols() == 0) return Matrix6X(6, 0);
  return system_->scale().twist().cwiseInverse().asDiagonal() * spatial::range_of(null, 1e-9);
}

}  // namespace kinetostat::vjm
