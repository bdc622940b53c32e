#include "kinetostat/vjm/statics/assembly.h"

#include "kinetostat/vjm/statics/newton_matrix.h"

namespace kinetostat::vjm {

Assembly assemble(const Manipulator& manipulator, const Posture& posture,
                  const EquilibriumOptions& options) {
  const Load nothing{.gravity = 0};
  const EquilibriumSystem system(manipulator, posture);
  const EquilibriumResiduals relaxed(system, system.relaxed_state(), nothing);
  // From the relaxed posture the first Newton correction is the linear solution.
  SystemVector first;
  NewtonMatrix(relaxed, false).solve(relaxed.newton_right_hand_side(false), first);
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
