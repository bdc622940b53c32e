#include "kinetostat/calibration/campaign/joint_loads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/campaign/load_history.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/particles.h"
#include "kinetostat/vjm/effects/watcher.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::calibration {
namespace {

using spatial::Vector3;
using spatial::Vector6;

constexpr double step = 1e-6;          // [m or rad], of the central difference
constexpr double least_motion = 1e-6;  // of a component, per m or rad of the joint: none

vjm::PostureResult posture_of(const vjm::Manipulator& manipulator, const Configuration& command) {
  return command.target ? vjm::posture_at(manipulator, *command.target)
                        : vjm::posture_from_joints(manipulator, command.joints);
}

// All its coordinates by name; passive ones are where the search for a posture starts.
std::map<std::string, double> coordinates_of(const vjm::Manipulator& manipulator,
                                             const vjm::Posture& posture) {
  std::map<std::string, double> values;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const vjm::Chain& chain = manipulator.chains()[c];
    for (const Eigen::Index k : chain.posture_coordinates())
      values[chain.name() + "." + chain.coordinates()[static_cast<std::size_t>(k)].name] =
          posture.coordinates[c][k];
  }
  return values;
}

bool has_spring(const vjm::Manipulator& manipulator, const std::string& joint) {
  for (const vjm::Chain& chain : manipulator.chains())
    for (const vjm::Spring& spring : chain.springs())
      if (chain.name() + "." + spring.name == joint) return true;
  return false;
}

// What happens per m or rad of a joint, the others standing still; 0 where the robot cannot follow.
struct Motion {
  Vector6 platform = Vector6::Zero();  // [translation; rotation] of its reference point, base axes
  Eigen::VectorXd seen;                // one entry a component of the campaign
  std::optional<std::array<vjm::Posture, 2>> between = {};  // a step behind and ahead
};

Vector6 rate(const spatial::Pose& behind, const spatial::Pose& ahead) {
  Vector6 rate;
  rate.head<3>() = (ahead.position() - behind.position()) / (2 * step);
  rate.tail<3>() =
      spatial::log_rotation(ahead.rotation() * behind.rotation().transpose()) / (2 * step);
  return rate;
}

// Of the platform, as it is measured.
Vector6 seen_of_platform(const Campaign& campaign, const spatial::Pose& platform,
                         const Vector6& motion) {
  Vector6 seen = campaign.observation.motion(platform, motion);
  if (campaign.observation.platform_axes) {
    seen.head<3>() = (platform.rotation().transpose() * seen.head<3>()).eval();
    seen.tail<3>() = (platform.rotation().transpose() * seen.tail<3>()).eval();
  }
  return seen;
}

// Postures with the joint a step behind, where it is, and a step ahead.
struct Steps {
  vjm::Posture behind, at, ahead;
};

std::vector<Vector6> seen_by_sensors(const Campaign& campaign, const vjm::Manipulator& manipulator,
                                     const Steps& steps, const Vector6& platform) {
  const Vector3 up = vjm::vertical(manipulator);
  std::vector<Vector6> rates;
  for (const Sensor& sensor : campaign.sensors) {
    if (sensor.is_platform()) {
      rates.push_back(seen_of_platform(campaign, steps.at.platform, platform));
      continue;
    }
    const auto seen = [&](const vjm::Posture& posture) {
      return seen_by(sensor, vjm::watched_at_rest(campaign.watch, manipulator, posture, 0),
                     campaign.watch, up)
          .pose;
    };
    Vector6& seen_rate = rates.emplace_back(rate(seen(steps.behind), seen(steps.ahead)));
    if (!sensor.own_axes) continue;
    const spatial::Matrix3 back = seen(steps.at).rotation().transpose();
    seen_rate << back * seen_rate.head<3>(), back * seen_rate.tail<3>();
  }
  return rates;
}

Motion motion_of(const Campaign& campaign, const vjm::Manipulator& manipulator,
                 const vjm::Posture& posture, std::map<std::string, double> values,
                 const std::string& joint) {
  const double at = values.at(joint);
  values[joint] = at + step;
  const vjm::PostureResult ahead = vjm::posture_from_joints(manipulator, values);
  values[joint] = at - step;
  const vjm::PostureResult behind = vjm::posture_from_joints(manipulator, values);
  Motion motion{.seen = Eigen::VectorXd::Zero(campaign.size())};
  if (!ahead.reached || !behind.reached) return motion;
  motion.between = {behind.posture, ahead.posture};
  motion.platform = rate(behind.posture.platform, ahead.posture.platform);
  const std::vector<Vector6> rates = seen_by_sensors(
      campaign, manipulator, {behind.posture, posture, ahead.posture}, motion.platform);
  for (Eigen::Index k = 0; k < campaign.size(); ++k) {
    const Component& component = campaign.component(k);
    motion.seen[k] = rates[component.sensor][component.axis];
    if (const auto minus = campaign.sensors[component.sensor].minus)
      motion.seen[k] -= rates[*minus][component.axis];
  }
  // A force shows what moves that which is set.
  if (campaign.control) motion.seen[campaign.control->force] = motion.seen[campaign.control->set];
  return motion;
}

// Whether the readings measure such a motion.
bool is_seen(const Reading& reading, const Motion& motion) {
  for (const Eigen::Index k : components_in_use(reading))
    if (std::abs(motion.seen[k]) > least_motion) return true;
  return false;
}

Vector3 position_of(const vjm::NodeLoad& load, const vjm::Manipulator& manipulator,
                    const vjm::Posture& posture) {
  const vjm::Chain& chain = manipulator.chains()[load.chain];
  const vjm::Node& node = chain.nodes()[load.node];
  return vjm::frame_behind(chain, posture.coordinates_of(chain, load.chain), node.joints,
                           posture.body(manipulator.span(load.chain).from)) *
         node.position;
}

// Generalised force along a joint of the loads at nodes and in joints, and what it could be at
// most.
std::pair<double, double> force_of_others(const vjm::Load& load,
                                          const vjm::Manipulator& manipulator, const Motion& motion,
                                          bool turns) {
  double force = 0, most = 0;
  for (const vjm::NodeLoad& node : load.nodes) {
    if (!motion.between) break;
    const Vector3 behind = position_of(node, manipulator, (*motion.between)[0]);
    const Vector3 ahead = position_of(node, manipulator, (*motion.between)[1]);
    force += node.force.dot(ahead - behind) / (2 * step);
    most += node.force.norm() * (turns ? ahead.norm() : 1);
  }
  for (const vjm::JointForce& joint : load.joints) {
    if (!motion.between) break;
    const auto coordinate = [&](std::size_t side) {
      return (*motion.between)[side].coordinates[joint.chain][joint.coordinate];
    };
    force += joint.force * (coordinate(1) - coordinate(0)) / (2 * step);
    most += std::abs(joint.force);
  }
  return {force, most};
}

// The same of the weight of the robot.
std::pair<double, double> force_of_weight(const vjm::Manipulator& manipulator, const Motion& motion,
                                          bool turns) {
  double force = 0, most = 0;
  if (!motion.between) return {force, most};
  const Vector3& gravity = manipulator.gravity();
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const vjm::Chain& chain = manipulator.chains()[c];
    const auto particles = [&](const vjm::Posture& posture) {
      const Eigen::VectorXd x = posture.coordinates_of(chain, c);
      vjm::ChainKinematics kinematics;
      const spatial::Pose& from = posture.body(manipulator.span(c).from);
      vjm::evaluate(chain, x, kinematics, from);
      return vjm::particles_of(chain, x, kinematics, from);
    };
    const auto behind = particles((*motion.between)[0]), ahead = particles((*motion.between)[1]);
    for (std::size_t p = 0; p < ahead.size(); ++p) {
      const Vector3 weight = ahead[p].mass * gravity;
      force += weight.dot(ahead[p].position - behind[p].position) / (2 * step);
      most += weight.norm() * (turns ? ahead[p].position.norm() : 1);
    }
  }
  return {force, most};
}

void count(const vjm::Manipulator& manipulator, const Reading& reading, const vjm::Load& load,
           const spatial::Pose& platform, const Motion& motion,
           const std::pair<double, double>& by_weight, JointLoad& joint, bool& driven) {
  const Vector6 wrench = load.at_reference_point(platform);
  auto [by_others, most_by_others] = force_of_others(load, manipulator, motion, joint.turns);
  by_others += by_weight.first;
  most_by_others += by_weight.second;
  const double force = wrench.dot(motion.platform) + by_others;
  const Vector3 point = platform * load.point_on_platform;
  const double most =
      most_by_others +
      (joint.turns ? load.force.norm() * point.norm() + load.moment.norm() : load.force.norm());
  joint.least = std::min(joint.least, force);
  joint.largest = std::max(joint.largest, force);
  if (!(most > 0)) return;
  const double share = std::abs(force) / most;
  joint.share = std::max(joint.share, share);
  if (share <= JointLoad::least_share) return;
  driven = true;
  joint.is_seen = joint.is_seen || is_seen(reading, motion);
}

}  // namespace

std::vector<JointLoad> joint_loads(const Campaign& campaign, const vjm::Manipulator& robot) {
  const vjm::Manipulator manipulator = vjm::with_watched(robot, campaign.watch);
  std::vector<JointLoad> result;
  std::vector<std::string> names;
  for (const Joint& joint : joints_of(manipulator)) {
    if (!joint.actuated || !has_spring(manipulator, joint.name)) continue;
    names.push_back(joint.name);
    result.push_back(
        {.name = joint.column(), .turns = joint.dimension == spatial::dimension::angle});
  }
  const std::vector<vjm::Load> loads = changing_loads(campaign);
  for (std::size_t c = 0; c < campaign.configurations.size(); ++c) {
    std::vector<std::size_t> here;
    for (std::size_t i = 0; i < campaign.readings.size(); ++i)
      if (campaign.readings[i].configuration == c && !campaign.readings[i].masked)
        here.push_back(i);
    if (here.empty()) continue;
    const vjm::PostureResult found = posture_of(manipulator, campaign.configurations[c]);
    if (!found.reached) continue;
    const auto values = coordinates_of(manipulator, found.posture);
    for (std::size_t j = 0; j < names.size(); ++j) {
      const Motion motion = motion_of(campaign, manipulator, found.posture, values, names[j]);
      // In differences it cancels.
      const auto by_weight = campaign.displacement == DisplacementKind::absolute
                                 ? force_of_weight(manipulator, motion, result[j].turns)
                                 : std::pair(0.0, 0.0);
      bool driven = false;
      for (const std::size_t i : here)
        count(manipulator, campaign.readings[i], loads[i], found.posture.platform, motion,
              by_weight, result[j], driven);
      result[j].postures += driven;
    }
  }
  return result;
}

}  // namespace kinetostat::calibration
