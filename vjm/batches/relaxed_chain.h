// A chain with relaxed springs, for many poses: rigid segments between the joints that a posture
// moves. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/batches/lanes.h"
#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

/// What all relaxed postures of a chain share. Springs of links do not move their coordinates from
/// zero: those on one segment are one compliance that is constant in the axes of the segment.
struct RelaxedChain {
  static constexpr int most_coordinates = 8, most_joints = 12;
  using Coordinates = LaneMatrix<Eigen::Dynamic, 1, most_coordinates, 1>;
  using Twists = LaneMatrix<6, Eigen::Dynamic, 6, most_coordinates>;

  struct Joint {
    spatial::Matrix3 rotation;  // from the segment before it
    spatial::Vector3 position;
    Motion motion = Motion::tx;
    int coordinate = 0;  // of those that a posture chooses, in their order
    double factor = 1;
  };
  struct Segment {
    int joints = 0;               // that lead to it
    spatial::Matrix6 compliance;  // of its springs, at its first joint's origin in its axes
  };
  struct Chosen {
    Eigen::Index coordinate = 0;  // in the chain
    double compliance = 0;        // of its own spring; 0: it has none
    bool is_free = false;         // a perfect passive joint
    bool turns = false;
  };

  std::vector<Joint> joints;
  std::vector<Segment> segments;  // those with springs, nearest the base first
  std::vector<Chosen> chosen;     // the coordinates that a posture chooses
  spatial::Pose tail;             // from the last segment to the end
};

/// Of all chains; none when one has another shape: springs over segments or over several of the
/// chosen coordinates, or more joints than the above.
std::vector<RelaxedChain> relaxed_chains(const std::vector<Chain>& chains);

/// Where the joints of a relaxed chain stand, pose by pose.
struct RelaxedKinematics {
  Vector3Lanes origins[RelaxedChain::most_joints], axes[RelaxedChain::most_joints];
  Matrix3Lanes rotations[RelaxedChain::most_joints + 1];  // of the segments
  Vector3Lanes positions[RelaxedChain::most_joints + 1];
  Matrix3Lanes rotation;  // of the end
  Vector3Lanes position;
};

/// Base axes. `x`: the coordinates that the posture chooses.
inline void evaluate(const RelaxedChain& chain, const RelaxedChain::Coordinates& x,
                     RelaxedKinematics& at) {
  for (int i = 0; i < 3; ++i) {
    at.positions[0][i] = 0.0;
    for (int j = 0; j < 3; ++j) at.rotations[0](i, j) = i == j ? 1.0 : 0.0;
  }
  const auto lead = [&](std::size_t from, const spatial::Matrix3& rotation,
                        const spatial::Vector3& position, Matrix3Lanes& r, Vector3Lanes& p) {
    for (int i = 0; i < 3; ++i) {
      Lanes sum = at.positions[from][i];
      for (int k = 0; k < 3; ++k) sum += at.rotations[from](i, k) * position[k];
      p[i] = sum;
      for (int j = 0; j < 3; ++j)
        r(i, j) = at.rotations[from](i, 0) * rotation(0, j) +
                  at.rotations[from](i, 1) * rotation(1, j) +
                  at.rotations[from](i, 2) * rotation(2, j);
    }
  };
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    const RelaxedChain::Joint& joint = chain.joints[j];
    Matrix3Lanes& r = at.rotations[j + 1];
    Vector3Lanes& p = at.positions[j + 1];
    lead(j, joint.rotation, joint.position, r, p);
    const int axis = axis_index(joint.motion);
    at.origins[j] = p;
    for (int i = 0; i < 3; ++i) at.axes[j][i] = r(i, axis);
    const Lanes value = x[joint.coordinate] * joint.factor;
    if (!is_rotation(joint.motion)) {
      for (int i = 0; i < 3; ++i) p[i] += value * r(i, axis);
      continue;
    }
    Lanes c, s;
    for (int lane = 0; lane < lane_count; ++lane) {
      c.set(lane, std::cos(value[lane]));
      s.set(lane, std::sin(value[lane]));
    }
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int i = 0; i < 3; ++i) {
      const Lanes u = r(i, a), v = r(i, b);
      r(i, a) = c * u + s * v;
      r(i, b) = c * v - s * u;
    }
  }
  lead(chain.joints.size(), chain.tail.rotation(), chain.tail.position(), at.rotation, at.position);
}

/// Twists [v; w] of the chosen coordinates at the end.
inline void twists_of(const RelaxedChain& chain, const RelaxedKinematics& at,
                      RelaxedChain::Twists& twists) {
  const Lanes zero(0.0);
  twists.resize(6, static_cast<Eigen::Index>(chain.chosen.size()));
  for (Eigen::Index k = 0; k < twists.cols(); ++k)
    for (int i = 0; i < 6; ++i) twists(i, k) = zero;
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    const RelaxedChain::Joint& joint = chain.joints[j];
    const int k = joint.coordinate;
    Vector3Lanes axis, arm;
    for (int i = 0; i < 3; ++i) {
      axis[i] = at.axes[j][i] * joint.factor;
      arm[i] = at.position[i] - at.origins[j][i];
    }
    if (!is_rotation(joint.motion)) {
      for (int i = 0; i < 3; ++i) twists(i, k) += axis[i];
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      twists(i, k) += axis[a] * arm[b] - axis[b] * arm[a];
      twists(3 + i, k) += axis[i];
    }
  }
}

}  // namespace kinetostat::vjm
