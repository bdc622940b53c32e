#include "kinetostat/vjm/effect_file.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::vjm {
namespace {

using files::YamlNode;
using spatial::Dimension;

double read_value(const YamlNode& node, const Dimension& dimension,
                  const spatial::UnitSystem& units) {
  namespace d = spatial::dimension;
  if (dimension == d::none) return node.number();
  for (const Dimension& of_file : {d::length, d::angle, d::mass, d::force, d::moment})
    if (dimension == of_file) return node.quantity(dimension, units);
  return node.quantity_with_unit(dimension);
}

// The places where a kind can act, as written in the file, with what each stands for.
struct Place {
  std::string name;
  std::size_t chain;
  std::string element;
};

// A link in segments has springs "leg.1", "leg.2", ...: the link is what is before the dot.
void add_links(const Chain& chain, std::vector<std::string>& elements) {
  for (const Spring& spring : chain.springs()) {
    if (spring.stiffness.rows() != 6) continue;
    const std::string link = spring.name.substr(0, spring.name.find('.'));
    if (std::find(elements.begin(), elements.end(), link) == elements.end())
      elements.push_back(link);
  }
}

std::vector<Place> places_of(const EffectKind& kind, const Manipulator& manipulator) {
  std::vector<Place> places;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    if (kind.place == EffectPlace::platform) {
      const Span& span = manipulator.span(c);
      if (span.from == Span::base && span.to == Span::platform)
        return {{.name = "platform", .chain = c, .element = {}}};
      continue;
    }
    std::vector<std::string> elements;
    if (kind.place == EffectPlace::link) add_links(chain, elements);
    if (kind.place == EffectPlace::joint)
      for (const Coordinate& coordinate : chain.coordinates())
        if (coordinate.role != Role::elastic) elements.push_back(coordinate.name);
    for (const std::string& element : elements) {
      places.push_back({chain.name() + "." + element, c, element});
      if (manipulator.size() == 1) places.push_back({element, c, element});
    }
  }
  return places;
}

Place read_place(const YamlNode& item, const EffectKind& kind, const Manipulator& manipulator) {
  const std::vector<Place> places = places_of(kind, manipulator);
  if (places.empty())
    item.fail(fmt::format("the robot has no {} on which '{}' could act", to_string(kind.place),
                          kind.name));
  std::vector<std::string> names;
  for (const Place& place : places) names.push_back(place.name);
  const std::string name = item.at("at").choice(names);
  return *std::find_if(places.begin(), places.end(),
                       [&](const Place& place) { return place.name == name; });
}

bool turns(const EffectKind& kind, const Manipulator& manipulator, const Place& place) {
  if (kind.place != EffectPlace::joint) return false;
  const Chain& chain = manipulator.chains()[place.chain];
  return is_rotation(
      chain.coordinates()[static_cast<std::size_t>(chain.index_of(place.element))].motion);
}

// `k3: 1e12 N/m^3`, or `k3: {value: ..., sd: ...}`.
void read_parameter(const YamlNode& node, const EffectParameter& parameter, bool angular,
                    const spatial::UnitSystem& units, double& value, double& deviation) {
  const Dimension& dimension = angular ? parameter.angular : parameter.linear;
  const bool has_deviation = node.is_map();
  if (has_deviation) node.allow_only({"value", "sd"});
  const YamlNode given = has_deviation ? node.at("value") : node;
  value = read_value(given, dimension, units);
  if (!(value >= parameter.lower && value <= parameter.upper))
    given.fail(fmt::format("{:.6g} is outside the physical range of '{}', {:.6g} to {:.6g} (SI)",
                           value, parameter.name, parameter.lower, parameter.upper));
  if (!has_deviation) return;
  if (const auto sd = node.find("sd")) {
    deviation = read_value(*sd, dimension, units);
    if (!(deviation >= 0)) sd->fail("a standard deviation must not be negative");
  }
}

Effect read_effect(const YamlNode& item, const Manipulator& manipulator,
                   const spatial::UnitSystem& units) {
  std::vector<std::string> names;
  for (const EffectKind& kind : effect_kinds()) names.push_back(kind.name);
  const EffectKind& kind = effect_kind(item.at("effect").choice(names));
  std::vector<std::string> keys{"effect", "at"};
  for (const EffectParameter& parameter : kind.parameters) keys.push_back(parameter.name);
  item.allow_only(keys);
  const Place place = read_place(item, kind, manipulator);
  const auto count = static_cast<Eigen::Index>(kind.parameters.size());
  Effect effect{
      .kind = &kind,
      .chain = place.chain,
      .element = place.element,
      .values = Eigen::VectorXd(count),
      .deviations = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN())};
  const bool angular = turns(kind, manipulator, place);
  for (Eigen::Index p = 0; p < count; ++p) {
    const EffectParameter& parameter = kind.parameters[static_cast<std::size_t>(p)];
    effect.values[p] = parameter.none;
    if (parameter.required || item.has(parameter.name))
      read_parameter(item.at(parameter.name), parameter, angular, units, effect.values[p],
                     effect.deviations[p]);
  }
  try {
    (void)kind.applied(manipulator.chains()[effect.chain], effect.element, effect.values);
  } catch (const std::invalid_argument& error) {
    item.at("at").fail(error.what());
  }
  return effect;
}

}  // namespace

std::vector<Effect> read_effects(const YamlNode& top, const Manipulator& manipulator,
                                 const spatial::UnitSystem& units) {
  std::vector<Effect> effects;
  if (const auto list = top.find("effects"))
    for (const YamlNode& item : list->items())
      effects.push_back(read_effect(item, manipulator, units));
  return effects;
}

}  // namespace kinetostat::vjm
