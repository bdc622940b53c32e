#include "kinetostat/vjm/equilibrium.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/vjm/equilibrium_state.h"

namespace kinetostat::vjm {
namespace {

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

// Without damping a step may go through a stop, from where the next one comes back to it.
enum class Damping { as_needed, none };

// Newton's method with Deuflhard's natural monotonicity test: a damped step is accepted when the
// correction seen from its end, with the old matrix, is smaller. This does not depend on how forces
// and lengths are weighed.
NewtonResult newton(EquilibriumSystem& system, const SystemState& start, const Load& load,
                    bool platform_held, const EquilibriumOptions& options,
                    Damping damping = Damping::as_needed) {
  NewtonResult result;
  result.state = start;
  const double reach = system.scale().length;
  const double enough = options.tolerance * reach;
  // What follows allocates nothing from its second round on (tests/vjm/allocation_test.cpp).
  result.corrections.reserve(static_cast<std::size_t>(options.max_iterations));
  SystemVector right, correction, again;
  SystemState next;
  for (int i = 0; i < options.max_iterations; ++i) {
    system.set(result.state, load);
    system.linearise(platform_held);
    system.newton_right_hand_side(right);
    system.solve(right, correction);
    result.consistent = system.consistent();
    const double size = correction.norm();
    result.corrections.push_back(size / reach);
    if (!std::isfinite(size) || size > 1e6 * reach) return result;

    double factor = 1;
    double simplified = 0;
    while (true) {
      system.moved(result.state, correction, factor, next);
      system.set(next, load);
      system.newton_right_hand_side(right);
      system.solve(right, again);
      simplified = again.norm();
      // Once corrections are down at rounding they cannot be asked to fall further.
      if (simplified <= (1 - factor / 4) * size || size <= enough || damping == Damping::none)
        break;
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

// A weak spring across the gap between two stops.
class AcrossGap : public CoordinateLaw {
 public:
  AcrossGap(double middle, double stiffness) : middle_(middle), stiffness_(stiffness) {}
  Value at(const JointState& joint) const override {
    const double d = joint.position - middle_;
    return {.energy = 0.5 * stiffness_ * d * d, .force = stiffness_ * d, .tangent = stiffness_};
  }

 private:
  double middle_, stiffness_;
};

bool has_gaps(const Manipulator& manipulator) {
  for (const Chain& chain : manipulator.chains())
    for (const auto& [coordinate, law] : chain.laws())
      if (dynamic_cast<const StopLaw*>(law.get()) != nullptr) return true;
  return false;
}

// With springs across all gaps, `share` as stiff as the stops.
Manipulator with_bridged_gaps(const Manipulator& manipulator, double share) {
  Manipulator bridged = manipulator;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    Chain chain = manipulator.chains()[c];
    for (const auto& [coordinate, law] : manipulator.chains()[c].laws())
      if (const auto* stop = dynamic_cast<const StopLaw*>(law.get()))
        chain.law(chain.coordinates()[static_cast<std::size_t>(coordinate)].name,
                  std::make_shared<AcrossGap>(stop->middle(), share * stop->stiffness()));
    bridged = bridged.with_chain(c, std::move(chain));
  }
  return bridged;
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

// Between stops a joint may move freely, so Newton's method cannot tell where a load takes it. The
// gap is bridged by springs that become softer and softer, until the joint lies at a stop, or is
// balanced without.
Equilibrium follow_through_gaps(const Manipulator& manipulator, const Posture& posture,
                                const Task& task, const EquilibriumOptions& options) {
  Equilibrium found = follow(manipulator, posture, task, options);
  if (found.status == EquilibriumStatus::converged || !has_gaps(manipulator)) return found;
  const Equilibrium first = follow(with_bridged_gaps(manipulator, 1), posture, task, options);
  if (first.status != EquilibriumStatus::converged) return found;
  SystemState state = state_of(first);
  EquilibriumSystem exact(manipulator, posture);
  for (double share = 0.1; share > 1e-10; share /= 10) {
    NewtonResult result = newton(exact, state, task.load, task.pose_given, options);
    if (result.converged) {
      Equilibrium equilibrium = describe(exact, manipulator, posture, result.state, task.load);
      equilibrium.status = EquilibriumStatus::converged;
      equilibrium.reached = 1;
      equilibrium.steps = found.steps + 1;
      equilibrium.corrections = std::move(result.corrections);
      return equilibrium;
    }
    const Manipulator bridged = with_bridged_gaps(manipulator, share);
    EquilibriumSystem softer(bridged, posture);
    result = newton(softer, state, task.load, task.pose_given, options, Damping::none);
    if (!result.converged) return found;
    state = result.state;
  }
  return found;
}

}  // namespace

Equilibrium equilibrium_at_pose(const Manipulator& manipulator, const Posture& posture,
                                const Pose& pose, const EquilibriumOptions& options,
                                const std::vector<NodeLoad>& node_loads) {
  return follow_through_gaps(manipulator, posture,
                             {true, posture.platform, pose, {.nodes = node_loads}}, options);
}

Equilibrium equilibrium_under_load(const Manipulator& manipulator, const Posture& posture,
                                   const Load& load, const EquilibriumOptions& options) {
  return follow_through_gaps(manipulator, posture,
                             {false, posture.platform, posture.platform, load}, options);
}

}  // namespace kinetostat::vjm
