// A tree of bodies as files for simulators. All are SI, with the posture as the state to start in
// where the format has one, and say in a comment what they do not hold.
#pragma once

#include <string>

#include "kinetostat/vjm/exchange/body_tree.h"

namespace kinetostat::vjm {

/// MuJoCo's XML (https://mujoco.readthedocs.io): springs as `stiffness` and `springref` of joints,
/// a site "tool", gravity, the posture as keyframe. Bodies get an inertia of a billionth more,
/// because MuJoCo asks for some about every axis.
std::string mjcf(const BodyTree& tree);

/// URDF (http://wiki.ros.org/urdf/XML). Springs are in Gazebo's extension (springStiffness,
/// springReference), which sdformat's reader takes; other readers pass it over. The link "tool" is
/// at the reference point. No gravity, no posture.
std::string urdf(const BodyTree& tree);

/// SDF 1.9 (http://sdformat.org/spec): a world with the gravity and a model that is fixed to it,
/// springs as `spring_stiffness` and `spring_reference` of axes. No posture.
std::string sdf(const BodyTree& tree);

/// A model in Modelica 3.x of the MultiBody library of its standard library (4.0): a Revolute or
/// Prismatic for each joint with a SpringDamper at its axis, which starts in the posture at rest.
std::string modelica(const BodyTree& tree);

}  // namespace kinetostat::vjm
