// Equilibria as states: found, then described. Internal to this module.
#pragma once

#include "kinetostat/vjm/statics/equilibrium_result.h"
#include "kinetostat/vjm/statics/equilibrium_system.h"
#include "kinetostat/vjm/statics/load.h"
#include "kinetostat/vjm/statics/newton_method.h"

namespace kinetostat::vjm {

/// State in which a search for an equilibrium ended; the members are those of Equilibrium.
struct FoundState {
  EquilibriumStatus status = EquilibriumStatus::not_converged;
  std::string reason;
  double reached = 0;
  SystemState state;
  int steps = 0;
  std::vector<double> corrections;
};

/// The state of equilibrium_under_load() without its description. `near` (or nullptr) is a state of
/// the same chains, or of these without springs that effects have appended, from which Newton's
/// method is tried first; then it leaves its equations.
FoundState state_under_load(const EquilibriumSystem& system, const Load& load,
                            const EquilibriumOptions& options, const SystemState* near = nullptr,
                            NewtonEquations* left = nullptr);

/// Wrenches, tangent stiffness, stability and energy at a state that balances `load`. `status` is
/// left for the caller.
Equilibrium describe(const EquilibriumSystem& system, const SystemState& state, const Load& load);

/// The state back from what is known of it.
SystemState state_of(const Equilibrium& equilibrium);

}  // namespace kinetostat::vjm
