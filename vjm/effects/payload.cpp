// A mass on the platform that the model does not know of.
#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

spatial::Vector3 center(const Eigen::VectorXd& values) { return values.segment<3>(1); }

Chain applied(const Chain& chain, const std::string&, const Eigen::VectorXd& values) {
  Chain result = chain;
  std::string name = "payload";
  const auto taken = [&] {
    for (const Node& node : chain.nodes())
      if (node.name == name) return true;
    return false;
  };
  while (taken()) name += "+";
  return result.mass(name, values[0], center(values));
}

Eigen::MatrixXd force_derivatives(const EffectState& state, const std::string&,
                                  const Eigen::VectorXd& values) {
  const spatial::Matrix3& rotation = state.kinematics.end.rotation();
  const spatial::Vector3 point = state.kinematics.end * center(values);
  const auto joints = static_cast<Eigen::Index>(state.chain.joints().size());
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(state.chain.size(), 4);
  const auto add = [&](Eigen::Index column, const spatial::Vector3& force,
                       const spatial::Vector3& moment) {
    spatial::Vector6 wrench;
    wrench << force, moment;
    Eigen::VectorXd generalised = Eigen::VectorXd::Zero(state.chain.size());
    add_generalised_force(state.chain, state.kinematics, {wrench, point, joints}, generalised);
    derivatives.col(column) = generalised;
  };
  add(0, state.gravity, spatial::Vector3::Zero());
  // The weight moved aside is the same weight with a moment.
  for (Eigen::Index i = 0; i < 3; ++i)
    add(1 + i, spatial::Vector3::Zero(), rotation.col(i).cross(values[0] * state.gravity));
  return derivatives;
}

}  // namespace

EffectKind payload() {
  const auto coordinate = [](const char* name) {
    return EffectParameter{.name = name,
                           .linear = spatial::dimension::length,
                           .angular = spatial::dimension::length,
                           .lower = -10,
                           .upper = 10,
                           .prior_sd = 0.1,
                           .required = false};
  };
  return {.name = "payload",
          .summary = "a mass on the platform, with its centre in platform axes",
          .law = "weight mass g at the point [x, y, z] of the platform",
          .source = "dead weight; MMT11 eq. 5 with a load at a node",
          .signature =
              "sag along gravity that depends on the posture; invisible in differences, "
              "but for the change of stiffness",
          .confuser = "self-weight of the last link",
          .place = EffectPlace::platform,
          .parameters = {{.name = "mass",
                          .linear = spatial::dimension::mass,
                          .angular = spatial::dimension::mass,
                          .lower = 0,
                          .upper = 1e5,
                          .prior_sd = 10},
                         coordinate("x"),
                         coordinate("y"),
                         coordinate("z")},
          .applied = applied,
          .force_derivatives = force_derivatives};
}

}  // namespace kinetostat::vjm::effects
