#include "kinetostat/vjm/effect.h"

#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/spatial/spelling.h"
#include "kinetostat/vjm/effects/kinds.h"
#include "kinetostat/vjm/equilibrium_state.h"

namespace kinetostat::vjm {
namespace {}  // namespace

namespace effects {

const Spring& spring_of_joint(const Chain& chain, const std::string& joint) {
  const Eigen::Index k = chain.index_of(joint);
  for (const Spring& spring : chain.springs())
    if (spring.first == k && spring.stiffness.rows() == 1) return spring;
  throw std::invalid_argument(
      fmt::format("joint '{}' of chain '{}' has no spring", joint, chain.name()));
}

}  // namespace effects

const std::vector<EffectKind>& effect_kinds() {
  static const std::vector<EffectKind> kinds = {
      effects::joint_compliance(), effects::link_compliance(), effects::hardening(),
      effects::clearance(),        effects::preload(),         effects::payload()};
  return kinds;
}

const EffectKind& effect_kind(const std::string& name) {
  std::vector<std::string> names;
  for (const EffectKind& kind : effect_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  const std::string near = spatial::nearest_spelling(name, names);
  throw std::invalid_argument(
      fmt::format("there is no effect '{}'{}", name,
                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

std::string to_string(EffectPlace place) {
  switch (place) {
    case EffectPlace::joint:
      return "joint";
    case EffectPlace::link:
      return "link";
    default:
      return "platform";
  }
}

std::string Effect::place(const Manipulator& manipulator) const {
  if (kind->place == EffectPlace::platform) return "platform";
  return manipulator.chains()[chain].name() + "." + element;
}

Manipulator with_effects(const Manipulator& manipulator, const std::vector<Effect>& effects) {
  Manipulator result = manipulator;
  for (const EffectKind& kind : effect_kinds())
    for (const Effect& effect : effects)
      if (effect.kind->name == kind.name)
        result = result.with_chain(effect.chain, kind.applied(result.chains().at(effect.chain),
                                                              effect.element, effect.values));
  return result;
}

Matrix6X displacement_by_effects(const Manipulator& manipulator, const Posture& posture,
                                 const Load& load, const Equilibrium& equilibrium,
                                 const std::vector<Effect>& effects) {
  EquilibriumSystem system(manipulator, posture);
  system.set(state_of(equilibrium), load);
  system.linearise(false);
  Eigen::Index count = 0, column = 0;
  for (const Effect& effect : effects) count += effect.values.size();
  Matrix6X derivatives(6, count);
  for (const Effect& effect : effects) {
    const ChainEquations& equations = system.chains()[effect.chain];
    const Eigen::VectorXd deflection = equations.deflection();
    const EffectState effect_state{manipulator.chains()[effect.chain], equations.coordinates(),
                                   deflection, equations.kinematics(),
                                   load.gravity * manipulator.gravity()};
    const Eigen::MatrixXd forces =
        effect.kind->force_derivatives(effect_state, effect.element, effect.values);
    for (Eigen::Index p = 0; p < forces.cols(); ++p) {
      SystemVector right = system.zero();
      right.coordinates[effect.chain] = -equations.gather_force(forces.col(p));
      derivatives.col(column++) =
          system.solve(right).bodies.head<6>().cwiseQuotient(system.scale().twist());
    }
  }
  return derivatives;
}

}  // namespace kinetostat::vjm
