#include "kinetostat/vjm/statics/equilibrium.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"
#include "kinetostat/vjm/statics/newton_method.h"

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

// A weak spring across the gap between two stops.
class AcrossGap : public CoordinateLaw {
 public:
  AcrossGap(double middle, double stiffness) : middle_(middle), stiffness_(stiffness) {}
  Value at(const JointState& joint) const override {
    const double d = joint.position - middle_;
    return {.force = stiffness_ * d, .tangent = stiffness_};
  }
  double energy(const JointState& joint) const override {
    return 0.5 * stiffness_ * std::pow(joint.position - middle_, 2);
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
    ChainModifier chain(manipulator.chains()[c]);
    for (const auto& [coordinate, law] : manipulator.chains()[c].laws())
      if (const auto* stop = dynamic_cast<const StopLaw*>(law.get()))
        chain.add_law(chain.chain().coordinates()[static_cast<std::size_t>(coordinate)].name,
                      std::make_shared<AcrossGap>(stop->middle(), share * stop->stiffness()));
    bridged = bridged.with_chain(c, std::move(chain).chain());
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
FoundState follow(const EquilibriumSystem& system, const Task& task,
                  const EquilibriumOptions& options) {
  FoundState found;
  found.state = system.relaxed_state();
  double step = 1;
  bool consistent = true;
  while (found.reached < 1 && found.steps < options.max_steps) {
    ++found.steps;
    const double share = std::min(1.0, found.reached + step);
    SystemState guess = found.state;
    if (task.pose_given) guess.bodies[0] = task.pose(share);
    NewtonResult result =
        newton(system, guess, task.load.scaled(share), {options, task.pose_given});
    found.corrections = std::move(result.corrections);
    if (result.converged) {
      found.state = std::move(result.state);
      found.reached = share;
      step *= 2;
    } else {
      // What the first correction cannot balance, no shorter step will; later ones may only have
      // come too far from equilibrium.
      consistent = result.consistent;
      step /= 2;
      if (step < 1e-6 || !consistent) break;
    }
  }
  if (found.reached == 1) {
    found.status = EquilibriumStatus::converged;
    return found;
  }
  found.reason = failure_reason(task, found.reached, consistent);
  if (!consistent)
    found.status = task.pose_given ? EquilibriumStatus::rigid : EquilibriumStatus::unsupported;
  return found;
}

// Between stops a joint may move freely, so Newton's method has no direction in which a load moves
// it. The gap is bridged by springs that become softer and softer, until the joint lies at a stop,
// or is balanced without.
FoundState follow_through_gaps(const EquilibriumSystem& exact, const Task& task,
                               const EquilibriumOptions& options) {
  const Manipulator& manipulator = exact.manipulator();
  FoundState found = follow(exact, task, options);
  if (found.status == EquilibriumStatus::converged || !has_gaps(manipulator)) return found;
  SystemState state;
  {
    const Manipulator bridged = with_bridged_gaps(manipulator, 1);
    const EquilibriumSystem system(bridged, exact.posture());
    FoundState first = follow(system, task, options);
    if (first.status != EquilibriumStatus::converged) return found;
    state = std::move(first.state);
  }
  constexpr int softenings = 10;
  double share = 1;
  for (int softening = 0; softening < softenings; ++softening) {
    share /= 10;
    NewtonResult result = newton(exact, state, task.load, {options, task.pose_given});
    if (result.converged)
      return {.status = EquilibriumStatus::converged,
              .reason = {},
              .reached = 1,
              .state = std::move(result.state),
              .steps = found.steps + 1,
              .corrections = std::move(result.corrections)};
    const Manipulator bridged = with_bridged_gaps(manipulator, share);
    const EquilibriumSystem softer(bridged, exact.posture());
    result =
        newton(softer, state, task.load, {options, task.pose_given, NewtonTask::Damping::none});
    if (!result.converged) return found;
    state = std::move(result.state);
  }
  return found;
}

// A state of a similar manipulator as one of this: springs that effects have appended to a chain
// stand at 0. nullopt: they are not that similar.
std::optional<SystemState> taken_over(const SystemState* near, const Manipulator& manipulator) {
  if (near == nullptr || near->coordinates.size() != manipulator.size() ||
      near->bodies.size() != manipulator.body_count())
    return std::nullopt;
  SystemState state = *near;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Eigen::Index size = manipulator.chains()[c].size();
    if (state.coordinates[c].size() > size) return std::nullopt;
    state.coordinates[c].conservativeResizeLike(Eigen::VectorXd::Zero(size));
  }
  return state;
}

Equilibrium equilibrium_of(const Manipulator& manipulator, const Posture& posture, const Task& task,
                           const EquilibriumOptions& options) {
  const EquilibriumSystem system(manipulator, posture);
  FoundState found = follow_through_gaps(system, task, options);
  Equilibrium equilibrium = describe(system, found.state, task.load.scaled(found.reached));
  equilibrium.status = found.status;
  equilibrium.reason = std::move(found.reason);
  equilibrium.reached = found.reached;
  equilibrium.steps = found.steps;
  equilibrium.corrections = std::move(found.corrections);
  return equilibrium;
}

}  // namespace

FoundState state_under_load(const EquilibriumSystem& system, const Load& load,
                            const EquilibriumOptions& options, const SystemState* near,
                            NewtonEquations* left) {
  if (const auto start = taken_over(near, system.manipulator())) {
    NewtonResult result = newton(
        system, *start, load,
        {.options = options, .platform_held = false, .matrix = NewtonTask::Matrix::kept_when_close},
        left);
    if (result.converged)
      return {.status = EquilibriumStatus::converged,
              .reason = {},
              .reached = 1,
              .state = std::move(result.state),
              .steps = 1,
              .corrections = std::move(result.corrections)};
  }
  const Pose& platform = system.posture().platform;
  return follow_through_gaps(system, {false, platform, platform, load}, options);
}

Equilibrium equilibrium_at_pose(const Manipulator& manipulator, const Posture& posture,
                                const Pose& pose, const EquilibriumOptions& options,
                                const std::vector<NodeLoad>& node_loads) {
  return equilibrium_of(manipulator, posture, {true, posture.platform, pose, {.nodes = node_loads}},
                        options);
}

Equilibrium equilibrium_under_load(const Manipulator& manipulator, const Posture& posture,
                                   const Load& load, const EquilibriumOptions& options) {
  return equilibrium_of(manipulator, posture, {false, posture.platform, posture.platform, load},
                        options);
}

}  // namespace kinetostat::vjm
