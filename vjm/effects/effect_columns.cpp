// Derivatives of a chain's equations by what effects change in it.
#include <cmath>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/effects/effect.h"

namespace kinetostat::vjm {

using Eigen::Index;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

namespace {

Vector6 value_at(const Chain& chain, const std::string& element, bool in_front) {
  for (const ChainDisplacement& place : chain.displacements())
    if (place.place == element && place.in_front == in_front) return place.value;
  return Vector6::Zero();
}

const Pose& before(const Chain& chain, Index joints) {
  return joints == static_cast<Index>(chain.joints().size())
             ? chain.tail()
             : chain.joints()[static_cast<std::size_t>(joints)].before;
}

// Whether a load stands behind a place. The first load of a state is that at the end.
bool carries(const ChainState& state, const PlaceFrame& place, std::size_t load) {
  if (load == 0) return true;
  return state.loads[load].joints > place.joints ||
         (!place.in_front && state.loads[load].joints == place.joints);
}

Vector3 velocity_of(const Vector3& point, const Vector3& centre, const Vector6& motion) {
  return motion.head<3>() + motion.tail<3>().cross(point - centre);
}

// Force that a wrench does work with on a motion of all that carries it.
double generalised_force(const PointWrench& load, const Vector3& centre, const Vector6& motion) {
  return load.wrench.head<3>().dot(velocity_of(load.point, centre, motion)) +
         load.wrench.tail<3>().dot(motion.tail<3>());
}

}  // namespace

PlaceFrame frame_of(const ChainState& state, const std::string& element, bool in_front) {
  in_front = in_front || element == "end";
  const Chain& chain = state.chain;
  PlaceFrame place;
  place.joints =
      in_front && element != "end" ? chain.first_joint_of(element) : chain.joints_to(element);
  place.in_front = in_front;
  place.pose = frame_behind(chain, state.x, place.joints, state.origin);
  if (in_front) {
    place.pose = place.pose * before(chain, place.joints);
    if (element == "end") place.pose = place.pose * chain.attachment().inverse();
    const Vector6 value = value_at(chain, element, true);
    if (!value.isZero(0)) place.pose = place.pose * spatial::displaced(Pose(), value).inverse();
  } else if (place.joints == 0) {
    place.pose = place.pose * chain.base();
  }
  return place;
}

void ChainColumns::renew(const ChainState& state, Index columns) {
  state_ = &state;
  force_.setZero(state.chain.size(), columns);
  drive_.setZero(state.chain.size(), columns);
  end_.setZero(6, columns);
  origin_.setZero(6, columns);
  motions_.resize(static_cast<std::size_t>(columns));
  for (std::vector<PlaceMotion>& motions : motions_) motions.clear();
}

void ChainColumns::add_force(Index column, Index coordinate, double force) {
  force_(coordinate, column) += force;
}

void ChainColumns::add_drive_force(Index column, Index coordinate, double force) {
  force_(coordinate, column) += force;
  drive_(coordinate, column) += force;
}

void ChainColumns::add_wrench(Index column, const PointWrench& load) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(state_->chain.size());
  add_generalised_force(state_->chain, state_->kinematics, load, force);
  force_.col(column) += force;
  origin_.col(column) += load.wrench;
  origin_.col(column).tail<3>() +=
      (load.point - state_->origin.position()).cross(load.wrench.head<3>());
}

// The place is one more joint of the chain: with joint i nearer the base than j,
// d(J_i . F)/dx_j = f . (w_i x v_j) and d(J_j . F)/dx_i = f . (w_i x v_j) + m . (w_i x w_j).
void ChainColumns::add_motion(Index column, const PlaceFrame& place, const Vector3& point,
                              const Vector6& motion) {
  const Vector3 w = motion.tail<3>(), end = state_->kinematics.end.position();
  motions_[static_cast<std::size_t>(column)].push_back(
      {place.joints, place.in_front, point, motion});
  end_.col(column).head<3>() += velocity_of(end, point, motion);
  end_.col(column).tail<3>() += w;
  for (std::size_t l = 0; l < state_->loads.size(); ++l) {
    if (!carries(*state_, place, l)) continue;
    const PointWrench& load = state_->loads[l];
    const Vector3 f = load.wrench.head<3>(), m = load.wrench.tail<3>();
    const Vector3 moved = velocity_of(load.point, point, motion);
    origin_.col(column).tail<3>() += moved.cross(f);
    for (Index j = 0; j < load.joints; ++j) {
      const Vector3 wj = state_->kinematics.joint_twists.col(j).tail<3>();
      const Vector3 vj =
          state_->kinematics.joint_twists.col(j).head<3>() + wj.cross(load.point - end);
      force_(state_->chain.joints()[static_cast<std::size_t>(j)].coordinate, column) +=
          j < place.joints ? f.dot(wj.cross(moved)) : f.dot(w.cross(vj)) + m.dot(w.cross(wj));
    }
  }
}

void ChainColumns::add_displacement(Index column, const std::string& element, bool in_front,
                                    const Vector6& change) {
  const PlaceFrame place = frame_of(*state_, element, in_front);
  const Vector6 value = value_at(state_->chain, element, place.in_front);
  Vector6 motion;
  motion << place.pose.rotation() * change.head<3>(),
      place.pose.rotation() * spatial::left_jacobian(value.tail<3>()) * change.tail<3>();
  add_motion(column, place, place.pose * Vector3(value.head<3>()), motion);
}

void ChainColumns::add_transmission_error(Index column, Index coordinate, double change) {
  if (state_->chain.stiffness()(coordinate, coordinate) != 0) {
    add_drive_force(column, coordinate, change * state_->drive_stiffness(coordinate));
    return;
  }
  // A joint held by its drive moves with it, and what it drives.
  const auto& joints = state_->chain.joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].coordinate != coordinate) continue;
    const auto column_of_joint = static_cast<Index>(j);
    const PlaceFrame place{.pose = {}, .joints = column_of_joint, .in_front = true};
    add_motion(column, place, state_->kinematics.end.position(),
               change * state_->kinematics.joint_twists.col(column_of_joint));
  }
}

void ChainColumns::add_compliance_behind(Index column, const std::string& element,
                                         const std::string& name, Motion motion, double change) {
  const Chain& chain = state_->chain;
  if (chain.has_coordinate(name)) {
    // F = -K x with 1/K the sum of compliances: dF/dc = K^2 x.
    const Index k = chain.index_of(name);
    const double stiffness = chain.stiffness()(k, k);
    add_force(column, k, change * stiffness * stiffness * state_->x[k]);
    return;
  }
  // Nothing there yields: the first trace of a compliance is the force there times its axis.
  const PlaceFrame place = frame_of(*state_, element, false);
  const Index joints = element == "end" ? chain.joints_to("end") : place.joints;
  const Pose frame =
      element == "end" ? frame_behind(chain, state_->x, joints, state_->origin) : place.pose;
  const Vector3 axis = frame.rotation().col(axis_index(motion));
  Vector6 unit;
  if (is_rotation(motion)) {
    unit << Vector3::Zero(), axis;
  } else {
    unit << axis, Vector3::Zero();
  }
  const PlaceFrame behind{.pose = frame, .joints = joints, .in_front = false};
  double force = 0;
  for (std::size_t l = 0; l < state_->loads.size(); ++l)
    if (carries(*state_, behind, l))
      force += generalised_force(state_->loads[l], frame.position(), unit);
  add_motion(column, behind, frame.position(), change * force * unit);
}

}  // namespace kinetostat::vjm
