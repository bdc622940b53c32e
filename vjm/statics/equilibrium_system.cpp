#include "kinetostat/vjm/statics/equilibrium_system.h"

#include <cassert>
#include <cmath>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using spatial::Vector6;

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

// Of all chains at a posture.
std::vector<ChainKinematics> kinematics_of(const Manipulator& manipulator, const Posture& posture) {
  std::vector<ChainKinematics> all(manipulator.size());
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    evaluate(chain, posture.coordinates_of(chain, c), all[c],
             posture.body(manipulator.span(c).from));
  }
  return all;
}

// The root of how much stiffer an elastic body is than the springs of the chains; 1 for all others.
std::vector<double> weights_of(const Manipulator& manipulator, const Scale& scale) {
  std::vector<double> weights(manipulator.size(), 1.0);
  for (const ElasticBody& body : manipulator.elastic_bodies()) {
    double largest = 0;
    for (Index k = 0; k < body.stiffness.rows(); ++k)
      largest =
          std::max(largest, body.stiffness(k, k) / (k % 6 < 3 ? 1 : std::pow(scale.length, 2)));
    for (const std::size_t c : body.chains)
      weights[c] = std::sqrt(std::max(1.0, largest / scale.stiffness));
  }
  return weights;
}

Scale scale_of(const Manipulator& manipulator, const std::vector<ChainKinematics>& kinematics) {
  double reach = 0;
  for (const ChainKinematics& chain : kinematics) reach = std::max(reach, chain.reach);
  const double length = reach > 0 ? reach : 1.0;
  return {.length = length, .stiffness = stiffest(manipulator, length)};
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
  const std::vector<ChainKinematics> kinematics = kinematics_of(manipulator, posture);
  scale_ = scale_of(manipulator, kinematics);
  const std::vector<double> weights = weights_of(manipulator, scale_);
  chains_.reserve(manipulator.size());
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    chains_.emplace_back(chain, posture.commands(chain, c), scale_,
                         manipulator.span(c).from != Span::base, kinematics[c], weights[c]);
    rigid_ |= chains_.back().is_rigid();
  }
}

SystemState EquilibriumSystem::relaxed_state() const {
  SystemState state;
  for (int body = 0; body < static_cast<int>(manipulator_.body_count()); ++body)
    state.bodies.push_back(posture_.body(body));
  state.wrenches.assign(chains_.size(), Vector6::Zero());
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Chain& chain = manipulator_.chains()[c];
    // A drive starts where it leads its joint; without a spring it stays there.
    state.coordinates.push_back(chain.rest_for(posture_.coordinates_of(chain, c)));
  }
  return state;
}

SystemVector EquilibriumSystem::zero() const {
  SystemVector v;
  make_zero(v);
  return v;
}

void EquilibriumSystem::make_zero(SystemVector& v) const {
  v.bodies.setZero(body_rows(false));
  v.wrenches.assign(chains_.size(), Vector6::Zero());
  v.coordinates.resize(chains_.size());
  for (std::size_t c = 0; c < chains_.size(); ++c) v.coordinates[c].setZero(chains_[c].size());
}

VectorXd EquilibriumSystem::flat(const SystemVector& vector, bool platform_held) const {
  VectorXd z;
  flat(vector, platform_held, z);
  return z;
}

void EquilibriumSystem::flat(const SystemVector& vector, bool platform_held, VectorXd& z) const {
  const Index bodies = body_rows(platform_held);
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

SystemVector EquilibriumSystem::from_flat(const VectorXd& z, bool platform_held) const {
  SystemVector vector;
  from_flat(z, platform_held, vector);
  return vector;
}

void EquilibriumSystem::from_flat(const VectorXd& z, bool platform_held,
                                  SystemVector& vector) const {
  const Index bodies = body_rows(platform_held);
  assert(z.size() >= bodies);
  make_zero(vector);
  vector.bodies.tail(bodies) = z.head(bodies);
  Index at = bodies;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    vector.wrenches[c] = z.segment<6>(at);
    vector.coordinates[c] = z.segment(at + 6, chains_[c].size());
    at += 6 + chains_[c].size();
  }
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

bool EquilibriumSystem::kinks(const SystemState& from, SystemState& to) const {
  bool any = false;
  for (std::size_t c = 0; c < chains_.size(); ++c)
    any |= chains_[c].kinks(from.coordinates[c], to.coordinates[c]);
  return any;
}

VectorXd EquilibriumSystem::deflections(const ElasticBody& body, const SystemState& state) {
  VectorXd all(body.stiffness.rows());
  for (std::size_t i = 0; i < body.chains.size(); ++i)
    all.segment<6>(static_cast<Index>(6 * i)) = state.coordinates[body.chains[i]].head<6>();
  return all;
}

const spatial::Pose& EquilibriumSystem::pose(int body, const SystemState& state) {
  static const spatial::Pose base;
  return body == Span::base ? base : state.bodies[static_cast<std::size_t>(body)];
}

double EquilibriumSystem::wrench_norm(const SystemState& state) const {
  double sum = 0;
  for (const Vector6& wrench : state.wrenches)
    sum += scale_.wrench().cwiseProduct(wrench).squaredNorm();
  return std::sqrt(sum);
}

}  // namespace kinetostat::vjm
