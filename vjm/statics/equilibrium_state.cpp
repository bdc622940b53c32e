#include "kinetostat/vjm/statics/equilibrium_state.h"

#include "kinetostat/vjm/statics/newton_matrix.h"

namespace kinetostat::vjm {
namespace {

using spatial::Matrix6;

// Of the platform under its dead load, from the sum of the chains' stiffnesses. None where that is
// too ill-conditioned for its signs to be sure.
std::optional<Stability> platform_stability(const Scale& scale, const Load& load,
                                            const Equilibrium& equilibrium) {
  const Matrix6 tangent = equilibrium.stiffness->matrix() - load.derivative(equilibrium.platform);
  const Matrix6 scaled =
      scale.wrench().asDiagonal() * tangent * scale.twist().cwiseInverse().asDiagonal();
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
void describe_stability(const EquilibriumTangent& tangent, const Load& load,
                        Equilibrium& equilibrium) {
  const auto of_whole = [&tangent](bool held) {
    return stability_of(energy_spectrum(tangent.energy_hessian(held)));
  };
  if (!equilibrium.stiffness || !tangent.system().manipulator().is_parallel()) {
    equilibrium.held = of_whole(true);
    equilibrium.free = of_whole(false);
    return;
  }
  equilibrium.held = equilibrium.chains[0].held;
  for (std::size_t c = 1; c < equilibrium.chains.size(); ++c)
    equilibrium.held = combined(equilibrium.held, equilibrium.chains[c].held);
  const auto platform = platform_stability(tangent.system().scale(), load, equilibrium);
  equilibrium.free = platform ? combined(equilibrium.held, *platform) : of_whole(false);
}

void describe_chains(const EquilibriumResiduals& at, const EquilibriumTangent& tangent,
                     Equilibrium& equilibrium) {
  for (std::size_t c = 0; c < at.chains().size(); ++c) {
    ChainEquilibrium chain;
    chain.coordinates = at.state().coordinates[c];
    chain.wrench = spatial::Wrench::from_coordinates(at.state().wrenches[c],
                                                     {at.chains()[c].end().position()});
    chain.held = stability_of(energy_spectrum(tangent.chain_energy_hessian(c)));
    equilibrium.energy += at.chains()[c].energy();
    equilibrium.chains.push_back(std::move(chain));
  }
  for (const ElasticBody& body : at.system().manipulator().elastic_bodies())
    equilibrium.energy += at.forces(body).energy;
}

template <class Factor>
void take_stiffness(const Factor& factor, Equilibrium& equilibrium) {
  equilibrium.stiffness =
      spatial::Stiffness6(factor.platform_stiffness(), {equilibrium.platform.position()});
  try {
    equilibrium.compliance = equilibrium.stiffness->inverse();
  } catch (const std::domain_error&) {
    // Some motion is free: there is no compliance.
  }
}

void describe_tangent(const EquilibriumResiduals& at, const ChainwiseFactor& factor,
                      Equilibrium& equilibrium) {
  for (std::size_t c = 0; c < at.chains().size(); ++c) {
    equilibrium.chains[c].stiffness =
        spatial::Stiffness6(factor.chain_stiffness(c), {at.chains()[c].end().position()});
    equilibrium.chains[c].motion = factor.chain_motion(c);
  }
  take_stiffness(factor, equilibrium);
}

void describe_tangent(const EquilibriumResiduals& at, const WholeFactor& factor,
                      Equilibrium& equilibrium) {
  if (!at.system().has_rigid_directions()) {
    take_stiffness(factor, equilibrium);
    return;
  }
  const auto [compliance, consistent] = factor.platform_compliance();
  if (consistent)
    equilibrium.compliance = spatial::Compliance6(compliance, {equilibrium.platform.position()});
}

template <class Factor>
void describe_with(const EquilibriumResiduals& at, Equilibrium& equilibrium) {
  const Factor factor(at, false);
  describe_chains(at, factor.tangent(), equilibrium);
  describe_tangent(at, factor, equilibrium);
  describe_stability(factor.tangent(), at.load(), equilibrium);
}

}  // namespace

Equilibrium describe(const EquilibriumSystem& system, const SystemState& state, const Load& load) {
  const EquilibriumResiduals at(system, state, load);
  Equilibrium equilibrium;
  equilibrium.platform = state.bodies[0];
  equilibrium.inner_bodies.assign(state.bodies.begin() + 1, state.bodies.end());
  const spatial::Frame frame{equilibrium.platform.position()};
  equilibrium.displacement = spatial::Twist::from_coordinates(
      spatial::pose_difference(system.posture().platform, equilibrium.platform), frame);
  equilibrium.wrench = spatial::Wrench::from_coordinates(at.platform_wrench(), frame);
  equilibrium.has_inner_loads = !load.nodes.empty() || !load.joints.empty();
  if (system.is_chainwise()) {
    describe_with<ChainwiseFactor>(at, equilibrium);
  } else {
    describe_with<WholeFactor>(at, equilibrium);
  }
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
