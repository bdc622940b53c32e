// A link grows with its temperature.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace thermal_expansion_kind {
namespace {

enum Value { alpha, reference };

// Where the rigid parts of an element end, and the way along each [m], in the axes there.
struct Part {
  std::string element;
  spatial::Vector3 length;
};

std::vector<Part> parts_of(const Chain& chain, const std::string& element) {
  if (element == "base" || element == "end")
    throw std::invalid_argument(fmt::format(
        "'{}' has no length that could expand: name the joint or link that the part leads to",
        element));
  const auto part = [&chain](const std::string& name) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(chain.first_joint_of(name))];
    return Part{name,
                joint.nominal_before.rotation().transpose() * joint.nominal_before.position()};
  };
  std::vector<Part> parts;
  for (const Spring& spring : chain.springs())
    if (spring.stiffness.rows() == 6 && spring.name.starts_with(element + "."))
      parts.push_back(part(spring.name));
  if (parts.empty()) parts.push_back(part(element));
  return parts;
}

double warming(const EffectInput& input) {
  const auto& temperature = input.conditions.temperature;
  return temperature ? *temperature - input.values[reference] : 0;
}

class ThermalExpansion : public EffectKind {
 public:
  ThermalExpansion() {
    name = "thermal_expansion";
    effect_class = EffectClass::temperature;
    summary = "the part that leads to a joint, or a link, grows with the temperature";
    law = "its length vector times 1 + alpha (T - reference), T the temperature of the reading";
    source = "linear expansion; ISO 230-3, thermal effects on machine tools";
    signature =
        "an offset in proportion to the temperature, along the link; the load plays no part";
    confuser =
        "session_drift, when the temperature follows time; geometric_error, when it hardly changes";
    place = EffectPlace::element;
    varies = true;
    parameters = {optional_parameter("alpha", {.temperature = -1}, 1e-3, 1.2e-5),
                  // Not given: 20, as ISO 1 has it, where the temperature is in degrees Celsius.
                  {.name = "reference",
                   .linear = spatial::dimension::temperature,
                   .angular = spatial::dimension::temperature,
                   .lower = -300,
                   .upper = 2000,
                   .prior_sd = 5,
                   .none = 20,
                   .required = false,
                   .is_shape = true}};
    parameters[alpha].required = true;
  }

  void act(ChainModifier& modifier, const std::string& element,
           const EffectInput& input) const override {
    const std::vector<Part> parts = parts_of(modifier.chain(), element);
    for (const Part& part : parts)
      modifier.add_displacement(part.element, true,
                                translation(input.values[alpha] * warming(input) * part.length));
  }

  void differentiate(ChainColumns& columns, const std::string& element,
                     const EffectInput& input) const override {
    for (const Part& part : parts_of(columns.state().chain, element)) {
      columns.add_displacement(alpha, part.element, true,
                               translation(warming(input) * part.length));
      if (input.conditions.temperature)
        columns.add_displacement(reference, part.element, true,
                                 translation(-input.values[alpha] * part.length));
    }
  }

 private:
  static spatial::Vector6 translation(const spatial::Vector3& v) {
    spatial::Vector6 displacement = spatial::Vector6::Zero();
    displacement.head<3>() = v;
    return displacement;
  }
};

}  // namespace
}  // namespace thermal_expansion_kind

Kind thermal_expansion() { return std::make_shared<thermal_expansion_kind::ThermalExpansion>(); }

}  // namespace kinetostat::vjm::effects
