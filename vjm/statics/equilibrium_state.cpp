#include "kinetostat/vjm/statics/equilibrium_state.h"

namespace kinetostat::vjm {
namespace {

using spatial::Matrix6;

// Of the platform under its dead load, from the sum of the chains' stiffnesses. None where that is
// too ill-conditioned for its signs to be sure.
std::optional<Stability> platform_stability(const EquilibriumSystem& system, const Load& load,
                                            const Equilibrium& equilibrium) {
  const Matrix6 tangent = equilibrium.stiffness->matrix() - load.derivative(equilibrium.platform);
  const Matrix6 scaled = system.scale().wrench().asDiagonal() * tangent *
                         system.scale().twist().cwiseInverse().asDiagonal();
  const EnergySpectrum spectrum =
      energy_spectrum({0.5 * (scaled + scaled.transpose()), Eigen::MatrixXd::Identity(6, 6)});
  const Eigen::VectorXd sizes = spectrum.values.cwiseAbs();
  constexpr double safe = 1e-9;
  if (sizes.minCoeff() < safe * std::max(1.0, sizes.maxCoeff())) return std::nullopt;
  return stability_of(spectrum);
}

// Signs for the platform held and left free. For chains of finite stiffness that all run from the
// base, the inertia is that of the held chains plus that of the sum of their stiffnesses
// (Haynsworth), which is quick; otherwise that of the whole energy.
void describe_stability(const EquilibriumSystem& system, const Manipulator& manipulator,
                        const Load& load, Equilibrium& equilibrium) {
  const auto of_whole = [&system](bool held) {
    return stability_of(energy_spectrum(system.energy_hessian(held)));
  };
  if (!equilibrium.stiffness || !manipulator.is_parallel()) {
    equilibrium.held = of_whole(true);
    equilibrium.free = of_whole(false);
    return;
  }
  equilibrium.held = equilibrium.chains[0].held;
  for (std::size_t c = 1; c < equilibrium.chains.size(); ++c)
    equilibrium.held = combined(equilibrium.held, equilibrium.chains[c].held);
  const auto platform = platform_stability(system, load, equilibrium);
  equilibrium.free = platform ? combined(equilibrium.held, *platform) : of_whole(false);
}

void describe_chain(const EquilibriumSystem& system, std::size_t c, const SystemState& state,
                    Equilibrium& equilibrium) {
  const spatial::Frame frame{system.chains()[c].end().position()};
  ChainEquilibrium chain;
  chain.coordinates = state.coordinates[c];
  chain.wrench = spatial::Wrench::from_coordinates(state.wrenches[c], frame);
  chain.held = stability_of(energy_spectrum(system.chain_energy_hessian(c)));
  if (!system.has_rigid_directions()) {
    chain.stiffness = spatial::Stiffness6(system.chain_stiffness(c), frame);
    chain.motion = system.chain_motion(c);
  }
  equilibrium.energy += system.chains()[c].energy();
  equilibrium.chains.push_back(std::move(chain));
}

void describe_tangent(const EquilibriumSystem& system, const spatial::Frame& frame,
                      Equilibrium& equilibrium) {
  if (!system.has_rigid_directions()) {
    equilibrium.stiffness = spatial::Stiffness6(system.platform_stiffness(), frame);
    try {
      equilibrium.compliance = equilibrium.stiffness->inverse();
    } catch (const std::domain_error&) {
      // Some motion is free: there is no compliance.
    }
    return;
  }
  const Matrix6 compliance = system.platform_compliance();
  if (system.consistent()) equilibrium.compliance = spatial::Compliance6(compliance, frame);
}

}  // namespace

Equilibrium describe(EquilibriumSystem& system, const Manipulator& manipulator,
                     const Posture& posture, const SystemState& state, const Load& load) {
  Equilibrium equilibrium;
  equilibrium.platform = state.bodies[0];
  equilibrium.inner_bodies.assign(state.bodies.begin() + 1, state.bodies.end());
  const spatial::Frame frame{equilibrium.platform.position()};
  equilibrium.displacement = spatial::Twist::from_coordinates(
      spatial::pose_difference(posture.platform, equilibrium.platform), frame);
  system.set(state, load);
  equilibrium.wrench = spatial::Wrench::from_coordinates(system.platform_wrench(), frame);
  if (system.has_rigid_directions()) {
    system.linearise(false);
  } else {
    system.linearise_by_chains();
  }
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    describe_chain(system, c, state, equilibrium);
  describe_tangent(system, frame, equilibrium);
  describe_stability(system, manipulator, load, equilibrium);
  return equilibrium;
}

SystemState state_of(const Equilibrium& equilibrium) {
  SystemState state;
  state.bodies.push_back(equilibrium.platform);
  for (const spatial::Pose& body : equilibrium.inner_bodies) state.bodies.push_back(body);
  for (const ChainEquilibrium& chain : equilibrium.chains) {
    state.wrenches.push_back(chain.wrench.coordinates());
    state.coordinates.push_back(chain.coordinates);
  }
  return state;
}

}  // namespace kinetostat::vjm
