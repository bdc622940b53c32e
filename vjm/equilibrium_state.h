// What is to be known of an equilibrium that has been found. Internal to this room.
#pragma once

#include "kinetostat/vjm/equilibrium.h"
#include "kinetostat/vjm/equilibrium_system.h"

namespace kinetostat::vjm {

/// Wrenches, tangent stiffness, stability and energy at a state that balances `load`. Sets and
/// factorises the system there. `status` is left for the caller.
Equilibrium describe(EquilibriumSystem& system, const Manipulator& manipulator,
                     const Posture& posture, const SystemState& state, const Load& load);

/// The state back from what is known of it.
SystemState state_of(const Equilibrium& equilibrium);

}  // namespace kinetostat::vjm
