#include "kinetostat/vjm/statics/equilibrium_residuals.h"

#include <cassert>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using spatial::Vector6;

// Masses under gravity and loads at nodes.
NodeWrenches node_wrenches(const Manipulator& manipulator, std::size_t c, const Load& load) {
  NodeWrenches all;
  const auto add = [&all](std::size_t node, const spatial::Vector3& force,
                          const spatial::Vector3& moment) {
    Vector6 wrench;
    wrench << force, moment;
    if (!wrench.isZero(0)) all.emplace_back(node, wrench);
  };
  for (const PointMass& mass : manipulator.chains()[c].masses())
    add(mass.node, load.gravity * mass.mass * manipulator.gravity(), spatial::Vector3::Zero());
  for (const NodeLoad& node : load.nodes)
    if (node.chain == c) add(node.node, node.force, node.moment);
  return all;
}

CoordinateForces joint_forces(std::size_t c, const Load& load) {
  CoordinateForces all;
  for (const JointForce& joint : load.joints)
    if (joint.chain == c && joint.force != 0) all.emplace_back(joint.coordinate, joint.force);
  return all;
}

[[maybe_unused]] bool fits(const SystemState& state, const EquilibriumSystem& system) {
  return state.bodies.size() == system.manipulator().body_count() &&
         state.wrenches.size() == system.chains().size() &&
         state.coordinates.size() == system.chains().size();
}

}  // namespace

EquilibriumResiduals::EquilibriumResiduals(const EquilibriumSystem& system,
                                           const SystemState& state, const Load& load)
    : system_(&system), state_(state), load_(load) {
  assert(fits(state, system));
  chains_.reserve(system.chains().size());
  for (std::size_t c = 0; c < system.chains().size(); ++c)
    chains_.emplace_back(system.chains()[c], node_wrenches(system.manipulator(), c, load),
                         origin_of(c), state.coordinates[c], state.wrenches[c],
                         joint_forces(c, load));
}

void EquilibriumResiduals::move_to(const SystemState& state) {
  assert(fits(state, *system_));
  state_ = state;
  for (std::size_t c = 0; c < chains_.size(); ++c)
    chains_[c].move_to(origin_of(c), state.coordinates[c], state.wrenches[c]);
}

const spatial::Pose& EquilibriumResiduals::origin_of(std::size_t chain) const {
  return EquilibriumSystem::pose(system_->manipulator().span(chain).from, state_);
}

SystemVector EquilibriumResiduals::newton_right_hand_side(bool platform_held) const {
  SystemVector right;
  newton_right_hand_side(platform_held, right);
  return right;
}

void EquilibriumResiduals::newton_right_hand_side(bool platform_held, SystemVector& right) const {
  const Scale& scale = system_->scale();
  system_->make_zero(right);
  right.bodies.head<6>() = load_.at_reference_point(state_.bodies[0]);
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Span& span = system_->manipulator().span(c);
    right.bodies.segment<6>(system_->row_of(span.to, false)) -= state_.wrenches[c];
    if (span.from != Span::base)
      right.bodies.segment<6>(system_->row_of(span.from, false)) += chains_[c].wrench_on_origin();
    right.wrenches[c] = scale.twist().cwiseProduct(spatial::pose_difference(
        chains_[c].end(), state_.bodies[static_cast<std::size_t>(span.to)]));
    right.coordinates[c] = -chains_[c].unbalanced();
    for (const Index k : chains_[c].held()) right.coordinates[c][k] = 0;
  }
  add_elastic_bodies(right);
  const Vector6 force = scale.wrench();
  for (Index b = 0; b < right.bodies.size(); b += 6)
    right.bodies.segment<6>(b).array() *= force.array();
  if (platform_held) right.bodies.head<6>().setZero();
}

ElasticForces EquilibriumResiduals::forces(const ElasticBody& body) const {
  return elastic_forces(body, EquilibriumSystem::pose(body.origin, state_),
                        EquilibriumSystem::deflections(body, state_),
                        load_.gravity * system_->manipulator().gravity());
}

ElasticTangent EquilibriumResiduals::tangent(const ElasticBody& body) const {
  return elastic_tangent(body, EquilibriumSystem::pose(body.origin, state_),
                         EquilibriumSystem::deflections(body, state_),
                         load_.gravity * system_->manipulator().gravity());
}

// Bodies not scaled yet.
void EquilibriumResiduals::add_elastic_bodies(SystemVector& right) const {
  for (const ElasticBody& body : system_->manipulator().elastic_bodies()) {
    const ElasticForces acting = forces(body);
    for (std::size_t i = 0; i < body.chains.size(); ++i) {
      const ChainEquations& chain = system_->chains()[body.chains[i]];
      right.coordinates[body.chains[i]] -=
          acting.on_deflections.segment<6>(static_cast<Index>(6 * i))
              .cwiseQuotient(chain.unit() * system_->scale().stiffness);
    }
    if (body.origin != Span::base)
      right.bodies.segment<6>(system_->row_of(body.origin, false)) += acting.on_origin;
  }
}

Vector6 EquilibriumResiduals::platform_wrench() const {
  Vector6 sum = Vector6::Zero();
  for (const ElasticBody& body : system_->manipulator().elastic_bodies())
    if (body.origin == Span::platform) sum -= forces(body).on_origin;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const Span& span = system_->manipulator().span(c);
    if (span.to == Span::platform) sum += state_.wrenches[c];
    if (span.from == Span::platform) sum -= chains_[c].wrench_on_origin();
  }
  return sum;
}

spatial::Matrix6 EquilibriumResiduals::load_matrix() const {
  const Scale& scale = system_->scale();
  return scale.wrench().asDiagonal() * load_.derivative(state_.bodies[0]) *
         scale.twist().cwiseInverse().asDiagonal();
}

}  // namespace kinetostat::vjm
