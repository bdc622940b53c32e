// A chain with relaxed springs, for many poses: rigid segments between the joints that a posture
// moves. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/spatial/pose.h"
#include "kinetostat/vjm/batches/frames.h"
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
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    const RelaxedChain::Joint& joint = chain.joints[j];
    Matrix3Lanes& r = at.rotations[j + 1];
    Vector3Lanes& p = at.positions[j + 1];
    lead(at.rotations[j], at.positions[j], joint.rotation, joint.position, r, p);
    const int axis = axis_index(joint.motion);
    at.origins[j] = p;
    for (int i = 0; i < 3; ++i) at.axes[j][i] = r(i, axis);
    const Lanes value = x[joint.coordinate] * joint.factor;
    if (!is_rotation(joint.motion)) {
      for (int i = 0; i < 3; ++i) p[i] += value * r(i, axis);
      continue;
    }
    turn(axis, value, r);
  }
  const std::size_t last = chain.joints.size();
  lead(at.rotations[last], at.positions[last], chain.tail.rotation(), chain.tail.position(),
       at.rotation, at.position);
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
    const Vector3Lanes velocity = cross(axis, arm);
    for (int i = 0; i < 3; ++i) {
      twists(i, k) += velocity[i];
      twists(3 + i, k) += axis[i];
    }
  }
}

}  // namespace kinetostat::vjm
