// How a manipulator vibrates about a posture, its drives holding their commands.
#pragma once

#include <vector>

#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/statics/load.h"
#include "kinetostat/vjm/statics/spring_shares.h"

namespace kinetostat::vjm {

struct ManipulatorMode {
  double frequency = 0;  // [Hz]
  /// Displacement of the platform at its reference point, base axes [translation m; rotation rad],
  /// its largest component positive, and of the coordinates of every chain [m or rad], for a modal
  /// mass of 1 kg m^2: y' M y = 1.
  spatial::Vector6 platform = spatial::Vector6::Zero();
  std::vector<Eigen::VectorXd> coordinates = {};
  std::vector<SpringShare> springs = {};  // of the energy of the springs, the largest first
};

struct NaturalModes {
  std::vector<ManipulatorMode> modes;  // ascending
  /// Motions that move a mass and that no spring resists: their frequency is 0, and they are not
  /// among the modes.
  int free_motions = 0;
  double mass = 0;  // [kg] of all chains
  Posture posture;  // about which
};

/// Of all chains and elastic bodies [kg].
double mass_of(const Manipulator& manipulator);

/// The `count` lowest modes of K y = omega^2 M y, fewer where there are no more; springs relaxed
/// and no load, as for unloaded_stiffness(), laws in joints by their tangent there. y are the
/// coordinates that move and the motions of the bodies, as far as the chains agree on these. M is
/// of the masses of the chains, links with the inertia that is given or as uniform rods
/// (particles.h): what these have about their own axis is left out. The weight's and the preloads'
/// geometric stiffness is left out, too.
NaturalModes natural_modes(const Manipulator& manipulator, const Posture& posture, int count);

/// The same about the equilibrium that is found from the posture under dead loads and gravity. K is
/// the second derivative of the energy there on motions that keep the chains together: springs,
/// laws in joints, and what the loads, the weight and the preloads add to them (geometric
/// stiffness, MMT11 eq. 23); M is that of the displaced masses. A moment that is constant in base
/// axes has no energy: of its part of K the symmetric one is taken. Geometric errors stay. Throws
/// common::NoConvergence where there is no equilibrium, or an unstable one.
NaturalModes natural_modes(const Manipulator& manipulator, const Posture& posture, const Load& load,
                           int count);

/// The equations that these are the modes of, K y + M y'' = J' F for a wrench F = [force; moment]
/// on the platform at its reference point, base axes; J y is its displacement. y are coordinates in
/// which all motions are independent and the chains agree; what has neither mass nor stiffness is
/// left out.
struct SmallMotions {
  Eigen::MatrixXd stiffness, mass;
  Eigen::Matrix<double, 6, Eigen::Dynamic> platform;
};
SmallMotions small_motions(const Manipulator& manipulator, const Posture& posture);
/// About the equilibrium under a load, as natural_modes() has it.
SmallMotions small_motions(const Manipulator& manipulator, const Posture& posture,
                           const Load& load);

}  // namespace kinetostat::vjm
