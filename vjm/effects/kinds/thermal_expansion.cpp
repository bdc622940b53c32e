// A link grows with its temperature, or a screw or scale.
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace thermal_expansion_kind {
namespace {

enum Value { alpha, reference, lag_time, grows };
// What grows where a part leads to a drive that slides.
enum Grows { part_and_screw, part_alone, screw_alone };

// Where the rigid parts of an element end, and the way along each [m], in the axes there.
struct Part {
  std::string element;
  spatial::Vector3 length;
};

// What is behind the last joint or link of a chain, but not on the body that it ends on.
Part end_of(const Chain& chain) {
  const spatial::Pose own = chain.without_errors().tail() * chain.attachment().inverse();
  return {"end", own.rotation().transpose() * own.position()};
}

std::vector<Part> parts_of(const Chain& chain, const std::string& element) {
  if (element == "end" && !end_of(chain).length.isZero(1e-12)) return {end_of(chain)};
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

// A drive whose stroke grows as well: its screw or scale.
std::optional<Eigen::Index> screw_of(const Chain& chain, const std::string& element) {
  for (std::size_t k = 0; k < chain.coordinates().size(); ++k) {
    const Coordinate& c = chain.coordinates()[k];
    if (c.name == element && c.role == Role::actuated && !is_rotation(c.motion))
      return static_cast<Eigen::Index>(k);
  }
  return std::nullopt;
}

Grows grows_of(const Eigen::VectorXd& values) {
  return static_cast<Grows>(std::lround(std::clamp(values[grows], 0.0, 2.0)));
}

// Of an element, as far as they grow.
struct Growing {
  std::vector<Part> parts;
  std::optional<Eigen::Index> screw;

  Growing(const Chain& chain, const std::string& element, const Eigen::VectorXd& values)
      : screw(screw_of(chain, element)) {
    const Grows which = grows_of(values);
    if (which != part_and_screw && !screw)
      throw std::invalid_argument(
          fmt::format("'{}' is no drive that slides: leave 'grows' out", element));
    if (which != screw_alone) parts = parts_of(chain, element);
    if (which == part_alone) screw.reset();
  }
};

class ThermalExpansion : public EffectKind {
 public:
  ThermalExpansion() {
    name = "thermal_expansion";
    effect_class = EffectClass::temperature;
    summary = "the part that leads to a joint, a link, or a screw grows with the temperature";
    law =
        "its length vector, and the command of a drive that slides, times 1 + alpha (T' - "
        "reference), lag dT'/dt + T' = T for the temperature T of the readings. At such a drive "
        "grows = 1 is the part alone, 2 the screw or scale alone";
    source = "linear expansion; ISO 230-3, thermal effects on machine tools";
    signature =
        "an offset in proportion to the temperature, along the link, of a screw to its stroke as "
        "well; the load plays no part";
    confuser =
        "session_drift, when the temperature follows time; geometric_error, when it hardly changes";
    place = EffectPlace::element;
    varies = true;
    by_temperature = true;
    acts_on_all = true;
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
                   .is_shape = true},
                  lag_of_temperature(),
                  {.name = "grows",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = 0,
                   .upper = 2,
                   .prior_sd = 1,
                   .required = false,
                   .is_shape = true,
                   .usual_linear = {0, 1, 2},
                   .usual_in_words = {"", "of the part before it", "of its screw or scale"}}};
    parameters[alpha].required = true;
    parameters[alpha].lower = -2e-6;  // carbon fibre along its length; all else grows
  }

  void act(ChainModifier& modifier, const std::string& element,
           const EffectInput& input) const override {
    const Warming warm = warming_of(input);
    const Growing growing(modifier.chain(), element, input.values);
    for (const Part& part : growing.parts)
      modifier.add_displacement(part.element, true,
                                translation(input.values[alpha] * warm.above * part.length));
    if (const auto k = growing.screw)
      modifier.add_transmission_error(
          {.coordinate = *k, .leader = *k, .ratio = input.values[alpha] * warm.above});
  }

  void differentiate(ChainColumns& columns, const std::string& element,
                     const EffectInput& input) const override {
    const Warming warm = warming_of(input);
    const Growing growing(columns.state().chain, element, input.values);
    for (const Part& part : growing.parts) {
      columns.add_displacement(alpha, part.element, true, translation(warm.above * part.length));
      if (!input.conditions.temperature) continue;
      columns.add_displacement(reference, part.element, true,
                               translation(-input.values[alpha] * part.length));
      columns.add_displacement(lag_time, part.element, true,
                               translation(input.values[alpha] * warm.by_lag * part.length));
    }
    if (const auto k = growing.screw) {
      const double command = columns.state().x[*k] - columns.state().travel[*k];
      columns.add_transmission_error(alpha, *k, warm.above * command);
      if (!input.conditions.temperature) return;
      columns.add_transmission_error(reference, *k, -input.values[alpha] * command);
      columns.add_transmission_error(lag_time, *k, input.values[alpha] * warm.by_lag * command);
    }
  }

 private:
  static Warming warming_of(const EffectInput& input) {
    return warming(input.conditions, input.values[reference], input.values[lag_time]);
  }
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
