// Cartesian stiffness of chains and manipulators without load.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/spatial/stiffness.h"
#include "kinetostat/vjm/chain/kinematics.h"
#include "kinetostat/vjm/manipulator/free_motion.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// Cartesian stiffness of one chain at its end point in base axes, springs relaxed (MMT11 Table 1,
/// IROS11 eq. 7), for any number of passive joints, redundant ones and singular postures included:
/// with N an orthonormal basis of the wrenches that the passive joints transmit (J_q' N = 0),
///
///     K_c = N (N' J_s K_s^-1 J_s' N)^-1 N',
///
/// which equals the block inverse where that exists. Nothing is returned when a transmitted wrench
/// meets no spring at all: the chain is rigid in that direction and has no stiffness matrix. Laws
/// of joints, which depend on where those stand, are left out.
std::optional<spatial::Stiffness6> unloaded_stiffness(const Chain& chain,
                                                      const ChainKinematics& kinematics);

/// The sum over the chains (IROS11 eq. 12; with inner bodies or rigid chains from the whole system
/// of equations) at the platform reference point in base axes, laws of joints by their tangents at
/// rest; nothing when the platform is rigid in some direction. The quick way, for maps; without
/// geometric errors, as below.
std::optional<spatial::Stiffness6> unloaded_stiffness_matrix(const Manipulator& manipulator,
                                                             const Posture& posture);

/// A manipulator in a posture, springs relaxed, laws of joints by their tangents there. Its
/// geometric errors do not count: with them the chains of an over-constrained robot close only
/// under internal loads, a state that equilibrium_under_load() and assemble() give, with its
/// stiffness. Motions may be free (no stiffness against them: then there is no compliance matrix)
/// or rigid (no compliance: then there is no stiffness matrix).
struct UnloadedStiffness {
  std::optional<spatial::Stiffness6> stiffness;  // at the platform reference point, base axes
  std::optional<spatial::Compliance6>
      compliance;  // its inverse, of rank below 6 with rigid motions
  std::vector<std::optional<spatial::Stiffness6>>
      per_chain;      // each at its end; same frame, and they add up (IROS11 eq. 12), without inner
                      // bodies
  FreeMotions free;   // motions that nothing resists
  FreeMotions rigid;  // wrenches to which nothing yields
  std::vector<FreeMotions> free_per_chain;  // of the chains that have a stiffness
  double length = 1;                        // reach of the longest chain [m], scales rotations
};

UnloadedStiffness unloaded_stiffness(const Manipulator& manipulator, const Posture& posture);

}  // namespace kinetostat::vjm
