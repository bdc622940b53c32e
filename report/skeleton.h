// A manipulator as lines: what a picture of it needs.
#pragma once

#include <string>

#include "kinetostat/files/json.h"
#include "kinetostat/vjm/equilibrium.h"

namespace kinetostat::report {

/// Every chain as a polyline from base to end with its joints (name, role, position, axis), and the
/// frames of platform and inner bodies. Base axes, [m].
files::Json skeleton(const vjm::Manipulator& manipulator, const vjm::Posture& posture);
/// The same in a loaded state, springs deflected.
files::Json skeleton(const vjm::Manipulator& manipulator, const vjm::Equilibrium& equilibrium);

/// One entry of a picture's "skeletons".
files::Json named_skeleton(const std::string& name, const files::Json& skeleton);
/// Only the polylines of the chains, for states of which there are many.
files::Json chain_lines(const vjm::Manipulator& manipulator, const vjm::Equilibrium& equilibrium);

}  // namespace kinetostat::report
