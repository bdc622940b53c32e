// Weights that are hung on parts of a robot, cylinders that push them apart, torques in joints.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/effects/watch.h"
#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::calibration {

/// A place where weights hang, by its column; `per_kilogram` is the load of 1 kg there, at the node
/// that with_watched() has made for it.
struct Weight {
  std::string name;
  vjm::NodeLoad per_kilogram;
};

/// A cylinder between two places, by its column: a force that pushes them apart, or pulls, along
/// the line through both as the robot stands without load.
struct Cylinder {
  std::string name;
  /// In Watch::frames; the first is pushed away from the second.
  std::array<std::size_t, 2> frames = {};
  /// Where the ends push: the node that with_watched() has made for them; none on the ground.
  std::array<std::optional<vjm::NodeLoad>, 2> ends = {};
};

/// A torque in a joint, by its column; a force where it slides.
struct Torque {
  std::string name;
  vjm::JointForce per_unit;
  spatial::Dimension dimension;
};

/// Adds to `load` a force along the line between these frames. Requires that they are apart.
void push_apart(const Cylinder& cylinder, const vjm::Watched& frames, double force,
                vjm::Load& load);

/// All forces at nodes together [N]; where they cancel, as those of a cylinder between two bodies,
/// that at the first node.
spatial::Vector3 force_at_nodes(const vjm::Load& load);

/// All forces and torques in joints together [N; N m], along the joints as they are without load.
spatial::Vector6 load_in_joints(const vjm::Load& load);

}  // namespace kinetostat::calibration
