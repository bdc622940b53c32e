// A further compliance in series with the spring of a joint: a shaft, a coupling, a soft mount.
#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

Chain applied(const Chain& chain, const std::string& joint, const Eigen::VectorXd& values) {
  const double stiffness = spring_of_joint(chain, joint).stiffness(0, 0);
  return chain.with_scaled_spring(joint, 1 / (1 + stiffness * values[0]));
}

// Several in series on one joint: 1/k = 1/k0 + sum of c, so dk/dc = -k^2 with the k of all of them.
Eigen::MatrixXd force_derivatives(const EffectState& state, const std::string& joint,
                                  const Eigen::VectorXd&) {
  const Spring& spring = spring_of_joint(state.chain, joint);
  const double stiffness = spring.stiffness(0, 0);
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(state.chain.size(), 1);
  // A gap in series with the spring knows its stiffness too.
  double force_by_stiffness = state.deflection[spring.first];
  for (const auto& [coordinate, law] : state.chain.laws())
    if (coordinate == spring.first)
      force_by_stiffness +=
          state.chain.value_of(coordinate, *law, state.x, state.deflection).force_by_stiffness;
  derivatives(spring.first, 0) = stiffness * stiffness * force_by_stiffness;
  return derivatives;
}

}  // namespace

EffectKind joint_compliance() {
  return {.name = "joint_compliance",
          .summary = "further compliance in series with the spring of a joint",
          .law = "1/k = 1/k0 + c",
          .source = "springs in series; MMT11 section 3",
          .signature = "displacement along the joint's motion, in proportion to the load",
          .confuser = "link_compliance of the next link",
          .place = EffectPlace::joint,
          .parameters = {{.name = "c",
                          .linear = {.mass = -1, .time = 2},
                          .angular = {.length = -2, .mass = -1, .time = 2, .angle = 1},
                          .lower = 0,
                          .upper = 1,
                          .prior_sd = 1e-6}},
          .applied = applied,
          .force_derivatives = force_derivatives};
}

}  // namespace kinetostat::vjm::effects
