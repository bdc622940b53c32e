// A tree of bodies as files for simulators. All are SI, with the posture as the state to start in
// where the format has one, and say in a comment what they do not hold: that of lost_in_...().
// Bodies of all but Modelica's have the least inertia (with_least_inertia).
#pragma once

#include <string>

#include "kinetostat/vjm/exchange/body_tree.h"

namespace kinetostat::vjm {

/// MuJoCo's XML (https://mujoco.readthedocs.io): springs as `stiffness` and `springref` of joints,
/// a site "tool", gravity, the posture as keyframe.
std::string mjcf(const BodyTree& tree);
std::vector<std::string> lost_in_mjcf(const BodyTree& tree);

/// URDF (http://wiki.ros.org/urdf/XML). Springs are in Gazebo's extension (springStiffness,
/// springReference), which sdformat's reader takes; other readers pass it over. The robot
/// stands on the link "world", which Gazebo fixes; the link "tool" is at the reference point. No
/// gravity, no posture.
std::string urdf(const BodyTree& tree);
std::vector<std::string> lost_in_urdf(const BodyTree& tree);

/// SDF 1.9 (http://sdformat.org/spec): a world with the gravity and a model that is fixed to it,
/// springs as `spring_stiffness` and `spring_reference` of axes. No posture.
std::string sdf(const BodyTree& tree);
std::vector<std::string> lost_in_sdf(const BodyTree& tree);

/// A model in Modelica 3.x of the MultiBody library of its standard library (4.0): a Revolute or
/// Prismatic for each joint with a SpringDamper at its axis, which starts in the posture at rest.
std::string modelica(const BodyTree& tree);
std::vector<std::string> lost_in_modelica(const BodyTree& tree);

}  // namespace kinetostat::vjm
