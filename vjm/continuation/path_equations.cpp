#include "kinetostat/vjm/continuation/path_equations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinetostat/vjm/chain/robust_factor.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

Load PathTask::load(double parameter) const {
  Load load = growing.scaled(parameter);
  load.nodes.insert(load.nodes.end(), constant.begin(), constant.end());
  load.gravity = 1;
  return load;
}

namespace {

// The six coordinates that a task drives: of a displacement, or of a wrench.
Vector6 driven(const PathTask& task) {
  if (task.platform_held) return task.displacement;
  Vector6 wrench;
  wrench << task.growing.force, task.growing.moment;
  return wrench;
}

// Their translation or force; where that is nothing, their rotation or moment.
Vector6 leading(const PathTask& task) {
  Vector6 part = driven(task);
  (turns(task) ? part.head<3>() : part.tail<3>()).setZero();
  return part;
}

// Where a full turn of a coordinate leads back to the same state: no spring and no law knows the
// difference, and every joint that it drives makes whole turns.
bool turns_freely(const Chain& chain, Index k) {
  if (!is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion)) return false;
  if (!chain.stiffness().row(k).isZero(0)) return false;
  for (const auto& [coordinate, law] : chain.laws())
    if (coordinate == k) return false;
  for (const Joint& joint : chain.joints())
    if (joint.coordinate == k && joint.factor != std::round(joint.factor)) return false;
  return true;
}

}  // namespace

Equilibrium equilibrium_at(const Manipulator& manipulator, const Posture& posture,
                           const PathTask& task, double parameter) {
  const Load load = task.load(parameter);
  if (!task.platform_held) return equilibrium_under_load(manipulator, posture, load);
  const Pose pose = spatial::displaced(posture.platform, parameter * task.displacement);
  return equilibrium_at_pose(manipulator, posture, pose, {}, load.nodes);
}

bool turns(const PathTask& task) { return driven(task).head<3>().isZero(0); }

PathEquations::PathEquations(const Manipulator& manipulator, const Posture& posture,
                             const PathTask& task)
    : manipulator_(manipulator),
      posture_(posture),
      task_(task),
      system_(manipulator, posture),
      weight_(system_.scale().length) {
  const double size = system_.scale().twist().cwiseProduct(task.displacement).norm();
  if (task.platform_held && size > 0) weight_ = size;
  for (const Chain& chain : manipulator.chains()) {
    turning_.emplace_back();
    for (const Index k : chain.free_coordinates())
      if (turns_freely(chain, k)) turning_.back().push_back(k);
  }
}

EquilibriumStatus PathEquations::start(double parameter, PathState& state,
                                       std::string& reason) const {
  state.parameter = parameter;
  if (parameter == 0 && task_.constant.empty() && manipulator_.is_relaxed_when_unloaded()) {
    state.state = system_.relaxed_state();
    return EquilibriumStatus::converged;
  }
  const Equilibrium found = equilibrium_at(manipulator_, posture_, task_, parameter);
  reason = found.reason;
  state.state = state_of(found);
  return found.status;
}

void PathEquations::balance_weight(const PathState& at) {
  if (task_.platform_held && !task_.displacement.isZero(0)) return;
  const LinearisedPath linear = linearised(at);
  const MatrixXd& matrix = linear.derivative();
  RobustFactor factor;
  factor.compute(matrix.leftCols(matrix.cols() - 1));
  const double moves = factor.solve(matrix.rightCols<1>()).norm() * weight_;
  if (std::isfinite(moves) && moves > 0) weight_ = std::min(moves, system_.scale().length);
}

EquilibriumResiduals PathEquations::residuals(const SystemState& state, double parameter) const {
  return {system_, state, task_.load(parameter)};
}

VectorXd PathEquations::flat_right_hand_side(const EquilibriumResiduals& at) const {
  const bool held = task_.platform_held;
  return system_.flat(at.newton_right_hand_side(held), held);
}

VectorXd PathEquations::right_hand_side(const PathState& at) const {
  return flat_right_hand_side(residuals(at.state, at.parameter));
}

LinearisedPath PathEquations::linearised(const PathState& at) const {
  const EquilibriumResiduals here = residuals(at.state, at.parameter);
  // The residuals are linear in the loads.
  const VectorXd by_load =
      flat_right_hand_side(residuals(at.state, at.parameter + 1)) - flat_right_hand_side(here);
  EquilibriumTangent tangent(here);
  MatrixXd matrix = derivative(tangent, by_load);
  return {std::move(tangent), std::move(matrix), task_.platform_held};
}

MatrixXd PathEquations::derivative(const EquilibriumTangent& tangent,
                                   const VectorXd& by_load) const {
  const MatrixXd all = tangent.matrix(false);
  const Index first = task_.platform_held ? 6 : 0, n = all.rows() - first;
  MatrixXd derivative(n, n + 1);
  derivative.leftCols(n) = all.bottomRightCorner(n, n);
  derivative.col(n) = -by_load;
  if (task_.platform_held)
    derivative.col(n) +=
        all.bottomLeftCorner(n, 6) * system_.scale().twist().cwiseProduct(task_.displacement);
  derivative.col(n) /= weight_;
  return derivative;
}

PathState PathEquations::moved(const PathState& from, const VectorXd& change) const {
  const Index n = change.size() - 1;
  PathState to{system_.moved(from.state, system_.from_flat(change.head(n), task_.platform_held), 1),
               from.parameter + change[n] / weight_};
  if (task_.platform_held)
    to.state.bodies[0] = spatial::displaced(posture_.platform, to.parameter * task_.displacement);
  return to;
}

VectorXd PathEquations::difference(const PathState& from, const PathState& to) const {
  const VectorXd flat = system_.flat(system_.difference(from.state, to.state), task_.platform_held);
  VectorXd all(flat.size() + 1);
  all << flat, (to.parameter - from.parameter) * weight_;
  return all;
}

VectorXd PathEquations::separation(const PathState& from, const PathState& to) const {
  constexpr double turn = 2 * std::numbers::pi;
  PathState nearest = to;
  for (std::size_t c = 0; c < turning_.size(); ++c)
    for (const Index k : turning_[c]) {
      double& x = nearest.state.coordinates[c][k];
      x -= turn * std::round((x - from.state.coordinates[c][k]) / turn);
    }
  return difference(from, nearest);
}

double PathEquations::motion(const VectorXd& change) const {
  SystemVector moves = system_.from_flat(change.head(change.size() - 1), task_.platform_held);
  for (Vector6& wrench : moves.wrenches) wrench.setZero();
  return moves.norm();
}

bool PathEquations::law_differs(const PathState& a, const PathState& b, double share) const {
  const std::vector<double> at_a = law_tangents(a), at_b = law_tangents(b);
  for (std::size_t i = 0; i < at_a.size(); ++i)
    if (std::abs(at_a[i] - at_b[i]) > share * std::max(std::abs(at_a[i]), std::abs(at_b[i])))
      return true;
  return false;
}

std::vector<double> PathEquations::law_tangents(const PathState& at) const {
  std::vector<double> tangents;
  const EquilibriumResiduals here = residuals(at.state, at.parameter);
  for (const ChainResiduals& chain : here.chains())
    for (const auto& [coordinate, law] : chain.equations().chain().laws())
      tangents.push_back(chain.value_of(coordinate, *law).tangent);
  return tangents;
}

VectorXd PathEquations::push() const {
  SystemVector push = system_.zero();
  for (std::size_t c = 0; c < manipulator_.size(); ++c)
    if (manipulator_.span(c).to == Span::platform)
      push.wrenches[c] = system_.scale().twist().cwiseProduct(task_.displacement);
  const VectorXd flat = system_.flat(push, task_.platform_held);
  VectorXd all(flat.size() + 1);
  all << flat, 0;
  return all;
}

PathPoint PathEquations::describe(const PathState& at, const VectorXd* tangent) const {
  const Load load = task_.load(at.parameter);
  PathPoint point;
  point.parameter = at.parameter;
  point.equilibrium = vjm::describe(system_, at.state, load);
  point.along = along(point.equilibrium, tangent);
  point.equilibrium.status = EquilibriumStatus::converged;
  point.equilibrium.reached = 1;
  point.potential = potential(point.equilibrium, load);
  return point;
}

std::optional<Along> PathEquations::along(const Equilibrium& equilibrium,
                                          const VectorXd* tangent) const {
  const Vector6 part = leading(task_);
  if (part.isZero(0)) return std::nullopt;
  const Vector6 direction = part.normalized();
  Along along{direction.dot(equilibrium.displacement.coordinates()),
              direction.dot(equilibrium.wrench.coordinates()),
              {}};
  if (!tangent) return along;
  const Index n = tangent->size() - 1;
  const SystemVector rate = system_.from_flat(tangent->head(n), task_.platform_held);
  const double driven_rate = (*tangent)[n] / weight_ * part.norm();
  double rise = driven_rate, run = 0;
  if (task_.platform_held) {
    run = driven_rate;
    rise = direction.dot(platform_wrench_rate(rate));
  } else {
    run = direction.head<6>().dot(
        rate.bodies.head<6>().cwiseQuotient(system_.scale().twist()).eval());
  }
  if (std::abs(run) > 1e-12 * std::abs(rise) / system_.scale().stiffness)
    along.stiffness = rise / run;
  if (task_.platform_held && equilibrium.stiffness)
    along.stiffness =
        direction.dot(equilibrium.stiffness->matrix() * task_.displacement) / part.norm();
  return along;
}

// Of chains that end on the platform. What others, that start there, press on it has no rate of its
// own in the system: the tangent stiffness is used for them where there is one.
Vector6 PathEquations::platform_wrench_rate(const SystemVector& rate) const {
  Vector6 sum = Vector6::Zero();
  for (std::size_t c = 0; c < manipulator_.size(); ++c)
    if (manipulator_.span(c).to == Span::platform)
      sum += rate.wrenches[c].cwiseQuotient(system_.scale().wrench());
  return sum;
}

double PathEquations::work_of_weight(const ElasticBody& body, const SystemState& state,
                                     const Load& load) const {
  return vjm::work_of_weight(body, EquilibriumSystem::pose(body.origin, state),
                             EquilibriumSystem::deflections(body, state),
                             load.gravity * manipulator_.gravity());
}

std::optional<double> PathEquations::potential(const Equilibrium& equilibrium,
                                               const Load& load) const {
  if (!task_.platform_held && !load.moment.isZero(0)) return std::nullopt;
  for (const NodeLoad& node : load.nodes)
    if (!node.moment.isZero(0)) return std::nullopt;
  double work = 0;
  if (!task_.platform_held)
    work += load.force.dot((equilibrium.platform * load.point_on_platform) -
                           (posture_.platform * load.point_on_platform));
  ChainKinematics now, then;
  for (std::size_t c = 0; c < manipulator_.size(); ++c) {
    const Chain& chain = manipulator_.chains()[c];
    const int from = manipulator_.span(c).from;
    evaluate(chain, equilibrium.chains[c].coordinates, now,
             from > 0 ? equilibrium.inner_bodies[static_cast<std::size_t>(from - 1)]
                      : (from == 0 ? equilibrium.platform : Pose()));
    evaluate(chain, posture_.coordinates[c], then, posture_.body(from));
    const auto work_at = [&](std::size_t node, const Vector3& force) {
      work += force.dot(now.nodes[node] - then.nodes[node]);
    };
    for (const PointMass& mass : chain.masses())
      work_at(mass.node, load.gravity * mass.mass * manipulator_.gravity());
    for (const NodeLoad& node : load.nodes)
      if (node.chain == c) work_at(node.node, node.force);
    for (const JointForce& joint : load.joints)
      if (joint.chain == c)
        work += joint.force * (equilibrium.chains[c].coordinates[joint.coordinate] -
                               posture_.coordinates[c][joint.coordinate]);
  }
  const SystemState state = state_of(equilibrium), relaxed = system_.relaxed_state();
  for (const ElasticBody& body : manipulator_.elastic_bodies())
    work += work_of_weight(body, state, load) - work_of_weight(body, relaxed, load);
  return equilibrium.energy - work;
}

}  // namespace kinetostat::vjm
