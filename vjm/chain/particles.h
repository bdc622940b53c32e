// The inertia of a chain: its point masses, placed as the links they stand for need them.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::vjm {

/// A point that moves with the first `joints` joints of a chain, and its mass.
struct Particle {
  spatial::Vector3 position;  // [m] base axes
  Eigen::Index joints = 0;
  double mass = 0;  // [kg]
};

/// All masses of a chain in the state of `kinematics`. The two halves of a part of a link
/// (LinkModel::append_to), which statics wants at L / 3 before and behind its centre, are at
/// L / sqrt(12), where they have the inertia of a uniform rod about its centre. Links are relaxed.
std::vector<Particle> particles_of(const Chain& chain, const ChainKinematics& kinematics);

}  // namespace kinetostat::vjm
