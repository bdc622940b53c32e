#include "kinetostat/vjm/equilibrium.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <fmt/format.h>

#include "kinetostat/vjm/equilibrium_system.h"

namespace kinetostat::vjm {
namespace {

using spatial::Matrix6;
using spatial::Pose;
using spatial::Vector6;

// What is asked for: a platform pose, or a load. Both are approached in steps from the posture.
struct Task {
  bool pose_given = false;
  Pose start, target;
  Load load;

  Pose pose(double share) const {
    return spatial::displaced(start, share * spatial::pose_difference(start, target));
  }
};

struct NewtonResult {
  bool converged = false;
  bool consistent = true;
  SystemState state;
  std::vector<double> corrections;
};

// Newton's method with Deuflhard's natural monotonicity test: a damped step is accepted when the
// correction seen from its end, with the old matrix, is smaller. This does not depend on how forces
// and lengths are weighed.
NewtonResult newton(EquilibriumSystem& system, const SystemState& start, const Load& load,
                    bool platform_held, const EquilibriumOptions& options) {
  NewtonResult result;
  result.state = start;
  const double reach = system.scale().length;
  const double enough = options.tolerance * reach;
  for (int i = 0; i < options.max_iterations; ++i) {
    system.set(result.state, load);
    system.linearise(platform_held);
    const SystemVector correction = system.solve(system.newton_right_hand_side());
    result.consistent = system.consistent();
    const double size = correction.norm();
    result.corrections.push_back(size / reach);
    if (!std::isfinite(size) || size > 1e6 * reach) return result;

    double factor = 1;
    SystemState next;
    double simplified = 0;
    while (true) {
      next = system.moved(result.state, correction, factor);
      system.set(next, load);
      simplified = system.solve(system.newton_right_hand_side()).norm();
      // Once corrections are down at rounding they cannot be asked to fall further.
      if (simplified <= (1 - factor / 4) * size || size <= enough) break;
      factor /= 2;
      if (factor < 1.0 / 1024) return result;
    }
    result.state = next;
    const bool at_rounding = size <= 1e-7 * reach && simplified <= 1e-2 * size;
    if (factor == 1 && (simplified <= enough || (at_rounding && simplified <= 1e3 * enough))) {
      result.converged = result.consistent;
      return result;
    }
  }
  return result;
}

std::string failure_reason(const Task& task, double reached, bool consistent) {
  if (!consistent)
    return task.pose_given
               ? "the pose cannot be held: some chain is rigid against part of this displacement"
               : "the load works on a motion that nothing resists; see the free motions that "
                 "'stiffness' lists";
  return fmt::format(
      "no equilibrium was found beyond {:.4g} % of the {}: the path ends near there (a limit point "
      "or "
      "a bifurcation), or the target is out of reach",
      100 * reached, task.pose_given ? "displacement" : "load");
}

// Signs for the platform held and left free. For chains of finite stiffness that all run from the
// base, the inertia is that of the held chains plus that of the sum of their stiffnesses
// (Haynsworth), which is quick; otherwise that of the whole energy.
void describe_stability(const EquilibriumSystem& system, const Manipulator& manipulator,
                        const Load& load, Equilibrium& equilibrium) {
  if (!equilibrium.stiffness || !manipulator.is_parallel()) {
    equilibrium.held = stability_of(system.energy_hessian(true));
    equilibrium.free = stability_of(system.energy_hessian(false));
    return;
  }
  equilibrium.held = equilibrium.chains[0].held;
  for (std::size_t c = 1; c < equilibrium.chains.size(); ++c)
    equilibrium.held = combined(equilibrium.held, equilibrium.chains[c].held);
  const Matrix6 tangent = equilibrium.stiffness->matrix() - load.derivative(equilibrium.platform);
  const Matrix6 scaled = system.scale().wrench().asDiagonal() * tangent *
                         system.scale().twist().cwiseInverse().asDiagonal();
  equilibrium.free = combined(equilibrium.held, stability_of(0.5 * (scaled + scaled.transpose())));
}

void describe_chain(const EquilibriumSystem& system, std::size_t c, const SystemState& state,
                    Equilibrium& equilibrium) {
  const spatial::Frame frame{system.chains()[c].end().position()};
  ChainEquilibrium chain;
  chain.coordinates = state.coordinates[c];
  chain.wrench = spatial::Wrench::from_coordinates(state.wrenches[c], frame);
  chain.held = stability_of(system.chain_energy_hessian(c));
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

// The whole task first; when Newton's method fails, in steps that halve and double.
Equilibrium follow(const Manipulator& manipulator, const Posture& posture, const Task& task,
                   const EquilibriumOptions& options) {
  EquilibriumSystem system(manipulator, posture);
  SystemState state = system.relaxed_state();
  double reached = 0, step = 1;
  bool consistent = true;
  std::vector<double> corrections;
  int steps = 0;
  while (reached < 1 && steps < options.max_steps) {
    ++steps;
    const double share = std::min(1.0, reached + step);
    SystemState guess = state;
    if (task.pose_given) guess.bodies[0] = task.pose(share);
    const NewtonResult result =
        newton(system, guess, task.load.scaled(share), task.pose_given, options);
    corrections = result.corrections;
    if (result.converged) {
      state = result.state;
      reached = share;
      step *= 2;
    } else {
      consistent = result.consistent;
      step /= 2;
      if (step < 1e-6 || !consistent) break;
    }
  }
  Equilibrium equilibrium =
      describe(system, manipulator, posture, state, task.load.scaled(reached));
  equilibrium.steps = steps;
  equilibrium.reached = reached;
  equilibrium.corrections = std::move(corrections);
  if (reached == 1) {
    equilibrium.status = EquilibriumStatus::converged;
    return equilibrium;
  }
  equilibrium.reason = failure_reason(task, reached, consistent);
  if (!consistent)
    equilibrium.status =
        task.pose_given ? EquilibriumStatus::rigid : EquilibriumStatus::unsupported;
  return equilibrium;
}

}  // namespace

Equilibrium equilibrium_at_pose(const Manipulator& manipulator, const Posture& posture,
                                const Pose& pose, const EquilibriumOptions& options,
                                const std::vector<NodeLoad>& node_loads) {
  return follow(manipulator, posture, {true, posture.platform, pose, {.nodes = node_loads}},
                options);
}

Equilibrium equilibrium_under_load(const Manipulator& manipulator, const Posture& posture,
                                   const Load& load, const EquilibriumOptions& options) {
  return follow(manipulator, posture, {false, posture.platform, posture.platform, load}, options);
}

}  // namespace kinetostat::vjm
