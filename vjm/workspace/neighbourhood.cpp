#include "kinetostat/vjm/workspace/neighbourhood.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm {
namespace {

constexpr double widest_turn = std::numbers::pi / 6;
constexpr std::size_t most_joints = 3;
constexpr int levels = 3;

PoseList cube(const spatial::Pose& centre, double distance) {
  PoseList list;
  list.shape = {levels, levels, levels, 1, 1, 1};
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k)
        list.poses.push_back(
            {.platform =
                 spatial::Pose::translation(distance * spatial::Vector3(i, j, k)) * centre});
  return list;
}

bool is_reached(const Manipulator& manipulator, const PoseList& list) {
  return std::all_of(list.poses.begin(), list.poses.end(), [&](const TargetPose& target) {
    return posture_at(manipulator, target.platform).reached;
  });
}

struct MovedJoint {
  std::string name;
  double lever;  // how far the platform goes [m] for each [m or rad] of it
  double least, most;
};

double lever(const Manipulator& manipulator, const Posture& posture, const std::string& name,
             double value) {
  constexpr double little = 1e-5;
  const PostureResult moved = posture_from_joints(manipulator, {{name, value + little}});
  return (moved.posture.platform.position() - posture.platform.position()).norm() / little;
}

MovedJoint moved_joint(const Coordinate& coordinate, const std::string& name, double lever,
                       double value, double distance) {
  double step = distance / lever;
  if (is_rotation(coordinate.motion)) step = std::min(step, widest_turn);
  MovedJoint joint{.name = name, .lever = lever, .least = value - step, .most = value + step};
  if (coordinate.range) {
    joint.least = std::max(joint.least, std::min((*coordinate.range)[0], value));
    joint.most = std::min(joint.most, std::max((*coordinate.range)[1], value));
  }
  return joint;
}

// The joints that move the platform most, in the order of the chains.
void leave_out_least(std::vector<MovedJoint>& joints) {
  const auto least = [](const MovedJoint& a, const MovedJoint& b) { return a.lever < b.lever; };
  // The last of equal ones: those of the base go on.
  joints.erase(std::min_element(joints.rbegin(), joints.rend(), least).base() - 1);
}

std::vector<MovedJoint> joints_of(const Manipulator& manipulator, const Posture& posture,
                                  double distance) {
  std::vector<MovedJoint> joints;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    for (const Eigen::Index k : chain.posture_coordinates()) {
      const Coordinate& coordinate = chain.coordinates()[static_cast<std::size_t>(k)];
      if (coordinate.role != Role::actuated) continue;
      const std::string name = chain.name() + "." + coordinate.name;
      const double value = posture.coordinates[c][k];
      const double arm = lever(manipulator, posture, name, value);
      if (arm > 0) joints.push_back(moved_joint(coordinate, name, arm, value, distance));
    }
  }
  while (joints.size() > most_joints) leave_out_least(joints);
  return joints;
}

PoseList moved_joints(const Manipulator& manipulator, const std::vector<MovedJoint>& joints) {
  std::size_t count = 1;
  for (std::size_t i = 0; i < joints.size(); ++i) count *= levels;
  PoseList list;
  for (std::size_t n = 0; n < count; ++n) {
    std::map<std::string, double> values;
    std::size_t digits = n;
    for (const MovedJoint& joint : joints) {
      const double at[levels] = {joint.least, 0.5 * (joint.least + joint.most), joint.most};
      values[joint.name] = at[digits % levels];
      digits /= levels;
    }
    list.poses.push_back({.platform = posture_from_joints(manipulator, values).posture.platform});
  }
  list.shape = {count, 1, 1, 1, 1, 1};
  return list;
}

}  // namespace

Neighbourhood neighbourhood(const Manipulator& manipulator, const Posture& posture,
                            double distance) {
  PoseList list = cube(posture.platform, distance);
  if (is_reached(manipulator, list)) return {list, {}};
  const std::vector<MovedJoint> joints = joints_of(manipulator, posture, distance);
  Neighbourhood result{moved_joints(manipulator, joints), {}};
  for (const MovedJoint& joint : joints) result.joints.push_back(joint.name);
  return result;
}

}  // namespace kinetostat::vjm
