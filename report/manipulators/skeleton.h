// A manipulator as lines: what a picture of it needs.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::report {

/// Every chain as a polyline from base to end with its joints (name, role, position, axis), and the
/// frames of platform and inner bodies. Base axes, [m]. A chain has the same number of points in
/// every state, so that what is between two states can be magnified.
io::Json skeleton(const vjm::Manipulator& manipulator, const vjm::Posture& posture);
/// The same in a loaded state, springs deflected.
io::Json skeleton(const vjm::Manipulator& manipulator, const vjm::Equilibrium& equilibrium);

/// The picture of natural modes: the posture at rest and, for each, the posture displaced by a
/// small part of it, so that what is between them can be magnified.
io::Json picture(const vjm::Manipulator& manipulator, const vjm::Posture& posture,
                 const std::vector<vjm::ManipulatorMode>& modes);

/// One entry of a picture's "skeletons".
io::Json named_skeleton(const std::string& name, const io::Json& skeleton);
/// The picture of a manipulator without geometric errors and load, and that of it beside a loaded
/// or assembled state, each under its name.
io::Json picture(const vjm::Manipulator& manipulator, const vjm::Posture& posture);
io::Json picture(const vjm::Manipulator& manipulator, const vjm::Posture& posture,
                 const vjm::Equilibrium& state, const std::string& relaxed = "unloaded",
                 const std::string& loaded = "loaded");
/// Only the polylines of the chains, for states of which there are many.
io::Json chain_lines(const vjm::Manipulator& manipulator, const vjm::Equilibrium& equilibrium);

}  // namespace kinetostat::report
