#include "kinetostat/vjm/statics/newton_matrix.h"

#include <cassert>

namespace kinetostat::vjm {

using Eigen::Index;

WholeFactor::WholeFactor(const EquilibriumResiduals& at, bool platform_held)
    : tangent_(at), held_(platform_held) {
  factorise();
}

void WholeFactor::renew(const EquilibriumResiduals& at) {
  tangent_.renew(at);
  factorise();
}

void WholeFactor::factorise() {
  tangent_.matrix(held_, matrix_);
  factor_.compute(matrix_);
}

bool WholeFactor::solve(const SystemVector& right, SystemVector& solution) const {
  const EquilibriumSystem& system = tangent_.system();
  system.flat(right, held_, right_);
  Index at = system.body_rows(held_);
  for (const ChainTangent& chain : tangent_.chains()) {
    for (const Index k : chain.held()) right_[at + 6 + k] = 0;
    at += 6 + chain.size();
  }
  bool consistent = true;
  solution_.resize(right_.size());
  factor_.solve(right_, solution_, &consistent);
  system.from_flat(solution_, held_, solution);
  return consistent;
}

WholeFactor::PlatformCompliance WholeFactor::platform_compliance() const {
  assert(!held_);
  const Scale& scale = tangent_.system().scale();
  PlatformCompliance compliance;
  SystemVector solution;
  for (int j = 0; j < 6; ++j) {
    SystemVector right = tangent_.system().zero();
    right.bodies[j] = scale.wrench()[j];
    compliance.consistent &= solve(right, solution);
    compliance.matrix.col(j) = solution.bodies.head<6>().cwiseQuotient(scale.twist());
  }
  return compliance;
}

// The platform's rows with all other unknowns eliminated.
spatial::Matrix6 WholeFactor::platform_stiffness() const {
  assert(!held_);
  const Scale& scale = tangent_.system().scale();
  const Index rest = matrix_.rows() - 6;
  RobustFactor followers;
  followers.compute(matrix_.bottomRightCorner(rest, rest));
  spatial::Matrix6 scaled = matrix_.topLeftCorner<6, 6>() + tangent_.load_matrix();
  scaled -= matrix_.topRightCorner(6, rest) * followers.solve(matrix_.bottomLeftCorner(rest, 6));
  return scale.wrench().cwiseInverse().asDiagonal() * scaled * scale.twist().asDiagonal();
}

namespace {

std::variant<ChainwiseFactor, SerialFactor, WholeFactor> factor_of(const EquilibriumResiduals& at,
                                                                   bool held) {
  const EquilibriumSystem& system = at.system();
  if (SerialFactor::can_factorise(system, held)) return SerialFactor(at);
  if (!system.is_chainwise()) return WholeFactor(at, held);
  return ChainwiseFactor(at, held);
}

}  // namespace

NewtonMatrix::NewtonMatrix(const EquilibriumResiduals& at, bool platform_held)
    : factor_(factor_of(at, platform_held)) {}

void NewtonMatrix::renew(const EquilibriumResiduals& at) {
  std::visit([&at](auto& factor) { factor.renew(at); }, factor_);
}

bool NewtonMatrix::solve(const SystemVector& right, SystemVector& solution) const {
  return std::visit([&](const auto& factor) { return factor.solve(right, solution); }, factor_);
}

bool NewtonMatrix::solve_bodies(const SystemVector& right, SystemVector& solution) const {
  if (const auto* chainwise = std::get_if<ChainwiseFactor>(&factor_))
    return chainwise->solve_bodies(right, solution);
  if (const auto* serial = std::get_if<SerialFactor>(&factor_))
    return serial->solve_bodies(right, solution);
  return solve(right, solution);
}

void NewtonMatrix::prepare_bodies() const {
  if (const auto* serial = std::get_if<SerialFactor>(&factor_)) serial->prepare_bodies();
}

bool NewtonMatrix::complete(std::size_t chain, const SystemVector& right,
                            SystemVector& solution) const {
  const auto* chainwise = std::get_if<ChainwiseFactor>(&factor_);
  return chainwise == nullptr || chainwise->complete(chain, right, solution);
}

}  // namespace kinetostat::vjm
