// Assembly of a manipulator whose chains have geometric errors (NONPERF section 3).
#pragma once

#include <vector>

#include "kinetostat/vjm/statics/equilibrium.h"

namespace kinetostat::vjm {

/// The platform and the chains after assembly, without weight and load.
struct Assembly {
  /// To first order in the errors (NONPERF eq. 13-16): shift of the platform, and the wrench that
  /// the platform exerts on each chain, at the platform's nominal position, base axes.
  spatial::Twist linear_shift;
  std::vector<spatial::Wrench> linear_wrenches;
  /// On the full equations (NONPERF eq. 19); its displacement is the shift, its chains' wrenches
  /// and coordinates are the internal loads and the joints' positions.
  Equilibrium assembled;
};

/// `posture` is that of the nominal manipulator. Chains without errors give a zero shift.
Assembly assemble(const Manipulator& manipulator, const Posture& posture,
                  const EquilibriumOptions& options = {});

}  // namespace kinetostat::vjm
