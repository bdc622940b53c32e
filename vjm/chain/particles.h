// The inertia of a chain: its point masses, placed as the links they stand for need them.
#pragma once

#include <vector>

#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::vjm {

/// A small body that moves with the first `joints` joints of a chain.
struct Particle {
  spatial::Vector3 position;  // [m] of its centre, base axes
  Eigen::Index joints = 0;
  double mass = 0;                                      // [kg]
  spatial::Matrix3 inertia = spatial::Matrix3::Zero();  // [kg m^2] about its centre, base axes
};

/// All masses of a chain in the state x of `kinematics`, links relaxed. `origin` is where the body
/// that the chain starts from stands. The two halves of a part of a link (LinkModel::append_to),
/// which statics wants at L / 3 before and behind its centre, are at L / sqrt(12), where they have
/// the inertia of a uniform rod about its centre. Where the inertia of the link is given they are
/// there or as much nearer as it asks for, and have what it has beside that, so that the rigid link
/// has the given mass, centre and inertia.
std::vector<Particle> particles_of(const Chain& chain, const Eigen::VectorXd& x,
                                   const ChainKinematics& kinematics,
                                   const spatial::Pose& origin = {});

/// Whether a body can have this inertia about its centre: the integral of (x x') dm that follows
/// from it is nowhere negative, but for rounding.
bool is_possible_inertia(const spatial::Matrix3& inertia);

}  // namespace kinetostat::vjm
