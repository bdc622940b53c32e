#include "kinetostat/vjm/effects/watcher.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/spelling.h"
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/statics/equilibrium_residuals.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

std::string node_name(std::size_t frame) { return fmt::format("watched {}", frame + 1); }

const Node& node_of(const Manipulator& manipulator, const Watch& watch, std::size_t frame) {
  const Chain& chain = manipulator.chains()[*watch.frames[frame].chain];
  return chain.nodes()[chain.node_index(node_name(frame))];
}

Pose pose_of(const Node& node, const Pose& joints) {
  return joints * Pose(node.axes, node.position);
}

// Motion of a point of a body that moves by [translation of its origin; rotation increment].
Vector6 at_point(const Vector6& motion, const Vector3& arm) {
  Vector6 result = motion;
  result.head<3>() += motion.tail<3>().cross(arm);
  return result;
}

}  // namespace

Manipulator with_watched(const Manipulator& manipulator, const Watch& watch) {
  Manipulator result = manipulator;
  for (std::size_t f = 0; f < watch.frames.size(); ++f) {
    const CarriedFrame& frame = watch.frames[f];
    if (!frame.chain) continue;
    ChainModifier chain(result.chains().at(*frame.chain));
    chain.add_node(node_name(f), frame.place, frame.pose);
    result = result.with_chain(*frame.chain, std::move(chain).chain());
  }
  return result;
}

Vector3 vertical(const Manipulator& manipulator) {
  if (manipulator.gravity().isZero(0)) return Vector3::UnitZ();
  return -manipulator.gravity().normalized();
}

namespace {

Pose frame_at_rest(const Watch& watch, std::size_t f, const Manipulator& manipulator,
                   const Posture& posture) {
  const CarriedFrame& frame = watch.frames[f];
  if (!frame.chain) return posture.body(frame.body) * frame.pose;
  const Node& node = node_of(manipulator, watch, f);
  const Chain& chain = manipulator.chains()[*frame.chain];
  return pose_of(node, frame_behind(chain, posture.coordinates_of(chain, *frame.chain), node.joints,
                                    posture.body(manipulator.span(*frame.chain).from)));
}

}  // namespace

Watched watched_at_rest(const Watch& watch, const Manipulator& manipulator, const Posture& posture,
                        Index parameters) {
  Watched result;
  for (std::size_t f = 0; f < watch.frames.size(); ++f)
    result.frames.push_back(frame_at_rest(watch, f, manipulator, posture));
  result.joints.setZero(2 * std::ssize(watch.joints));
  for (std::size_t j = 0; j < watch.joints.size(); ++j)
    result.joints[2 * static_cast<Index>(j)] =
        posture.coordinates[watch.joints[j].chain][watch.joints[j].coordinate];
  result.derivatives.setZero(watched_rows(watch), parameters);
  return result;
}

Watcher::Watcher(const Watch& watch, const EquilibriumResiduals& at, const ReadingErrors& errors)
    : watch_(watch), at_(at), errors_(errors) {
  errors_.target.setZero();
  const Manipulator& manipulator = at.system().manipulator();
  for (std::size_t f = 0; f < watch.frames.size(); ++f) {
    const CarriedFrame& frame = watch.frames[f];
    if (frame.chain) {
      const ChainResiduals& chain = at.chains()[*frame.chain];
      const Node& node = node_of(manipulator, watch, f);
      nodes_.push_back(&node);
      carried_.push_back(pose_of(node, frame_behind(chain.equations().chain(), chain.coordinates(),
                                                    node.joints, chain.origin())));
    } else {
      nodes_.push_back(nullptr);
      const Pose body = frame.body == Span::base
                            ? Pose()
                            : at.state().bodies[static_cast<std::size_t>(frame.body)];
      carried_.push_back(body * frame.pose);
    }
    values_.frames.push_back(frame.by_instrument ? errors_.observed(carried_.back())
                                                 : carried_.back());
  }
  values_.joints.resize(2 * std::ssize(watch.joints));
  for (std::size_t j = 0; j < watch.joints.size(); ++j) {
    const auto& [chain, coordinate] = watch.joints[j];
    values_.joints[2 * static_cast<Index>(j)] = at.chains()[chain].coordinates()[coordinate];
    values_.joints[2 * static_cast<Index>(j) + 1] = -chain_state(at, chain).drive_force(coordinate);
  }
}

std::vector<std::size_t> Watcher::chains_of(const Watch& watch) {
  std::vector<std::size_t> chains;
  for (const CarriedFrame& frame : watch.frames)
    if (frame.chain) chains.push_back(*frame.chain);
  for (const WatchedJoint& joint : watch.joints) chains.push_back(joint.chain);
  return chains;
}

Vector6 Watcher::motion_of(const CarriedFrame& frame, std::size_t index,
                           const EquationChange& equations, const StateDerivative& state) const {
  const Vector3& point = carried_[index].position();
  const auto of_body = [&](int body) -> Vector6 {
    if (body == Span::base) return Vector6::Zero();
    return at_point(state.bodies.segment<6>(Index{6} * body),
                    point - at_.state().bodies[static_cast<std::size_t>(body)].position());
  };
  if (!frame.chain) return of_body(frame.body);
  const Manipulator& manipulator = at_.system().manipulator();
  const Chain& chain = manipulator.chains()[*frame.chain];
  const ChainKinematics& kinematics = at_.chains()[*frame.chain].kinematics();
  const Node& node = *nodes_[index];
  const Vector3 from_end = point - kinematics.end.position();
  Vector6 motion = of_body(manipulator.span(*frame.chain).from);
  for (Index j = 0; j < node.joints; ++j)
    motion +=
        state.coordinates[*frame.chain][chain.joints()[static_cast<std::size_t>(j)].coordinate] *
        at_point(kinematics.joint_twists.col(j), from_end);
  for (const PlaceMotion& moved : equations.chains[*frame.chain].motions)
    if (moved.joints < node.joints || (!moved.in_front && moved.joints == node.joints))
      motion += at_point(moved.motion, point - moved.point);
  return motion;
}

Eigen::VectorXd Watcher::change(const EquationChange& equations, const StateDerivative& state,
                                const ReadingErrors* errors) const {
  Eigen::VectorXd result(watched_rows(watch_));
  Index row = 0;
  for (std::size_t f = 0; f < watch_.frames.size(); ++f, row += 6) {
    Vector6 motion = motion_of(watch_.frames[f], f, equations, state);
    if (watch_.frames[f].by_instrument) {
      motion = errors_.observed_motion(carried_[f], motion);
      if (errors != nullptr) {
        ReadingErrors of_frame = *errors;
        of_frame.target.setZero();
        motion += errors_.observed_derivative(carried_[f], of_frame);
      }
    }
    result.segment<6>(row) = motion;
  }
  for (const auto& [chain, coordinate] : watch_.joints) {
    const double moved = state.coordinates[chain][coordinate];
    result[row++] = moved;
    result[row++] = equations.chains[chain].drive[coordinate] -
                    chain_state(at_, chain).drive_stiffness(coordinate) * moved;
  }
  return result;
}

}  // namespace kinetostat::vjm
