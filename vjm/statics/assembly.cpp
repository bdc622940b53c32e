#include "kinetostat/vjm/statics/assembly.h"

#include "kinetostat/vjm/statics/equilibrium_system.h"

namespace kinetostat::vjm {

Assembly assemble(const Manipulator& manipulator, const Posture& posture,
                  const EquilibriumOptions& options) {
  const Load nothing{.gravity = 0};
  EquilibriumSystem system(manipulator, posture);
  system.set(system.relaxed_state(), nothing);
  system.linearise(false);
  // From the relaxed posture the first Newton correction is the linear solution.
  const SystemVector first = system.solve(system.newton_right_hand_side());
  const spatial::Frame frame{posture.platform.position()};
  Assembly assembly;
  assembly.linear_shift = spatial::Twist::from_coordinates(
      first.bodies.head<6>().cwiseQuotient(system.scale().twist()), frame);
  for (const spatial::Vector6& wrench : first.wrenches)
    assembly.linear_wrenches.push_back(
        spatial::Wrench::from_coordinates(wrench.cwiseQuotient(system.scale().wrench()), frame));
  assembly.assembled = equilibrium_under_load(manipulator, posture, nothing, options);
  return assembly;
}

}  // namespace kinetostat::vjm
