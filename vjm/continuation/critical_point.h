// Where a step of a path passes a limit point or a bifurcation. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/continuation/continuation.h"

namespace kinetostat::vjm {

struct CriticalStation {
  CriticalKind kind = CriticalKind::bifurcation;
  Station station;
  Station beside;          // on the path, where the tangent is defined
  int idle = 0;            // as branch_point.h has it
  int multiplicity = 1;    // motions that become free
  double uncertainty = 0;  // of the parameter
  int unstable_before = 0, unstable_after = 0;
};

/// All critical points between two neighbouring stations, in the order of the path. The inertia of
/// the energy differs on the two sides; or the parameter turns back without that, as it does on a
/// branch that passes through the vertex of a pitchfork.
std::vector<CriticalStation> critical_between(Continuation& continuation, const Station& from,
                                              const Station& to);

}  // namespace kinetostat::vjm
