// Robots described in MJCF, the format of MuJoCo.
#pragma once

#include "kinetostat/vjm/exchange/robot_description.h"

namespace kinetostat::vjm {

/// The tree of bodies of a MuJoCo model (https://mujoco.readthedocs.io, XML reference), with its
/// default classes and the files that it includes; the root is the link "world", sites are links
/// that carry nothing. A joint beside the origin of its body, or one of several of a body, leads to
/// a link "body@joint" between. Equality constraints of two joints become mimic joints, as far as
/// they are linear. Masses are those of <inertial>, or what geoms weigh, as the `inertiafromgeom`
/// and `inertiagrouprange` of the compiler have it; those of meshes and of shells are left out,
/// with a remark. Throws common::InputError with file and line when a file is not XML or not MJCF,
/// and for ball and free joints and composites.
RobotDescription read_mjcf(const std::filesystem::path& file);

}  // namespace kinetostat::vjm
