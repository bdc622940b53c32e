#include "kinetostat/vjm/io/effect_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/effects/kinds/user_effect.h"

namespace kinetostat::vjm {
namespace {

using io::YamlNode;
using spatial::Dimension;

double read_value(const YamlNode& node, const Dimension& dimension,
                  const spatial::UnitSystem& units) {
  namespace d = spatial::dimension;
  if (dimension == d::none) return node.number();
  for (const Dimension& of_file : {d::length, d::angle, d::mass, d::force, d::moment})
    if (dimension == of_file) return node.quantity(dimension, units);
  return node.quantity_with_unit(dimension);
}

// `k3: 1e12 N/m^3`, or `k3: {value: ..., sd: ...}`.
void read_parameter(const YamlNode& node, const EffectParameter& parameter, bool angular,
                    const spatial::UnitSystem& units, double& value, double& deviation) {
  const Dimension& dimension = angular ? parameter.angular : parameter.linear;
  const bool has_deviation = node.is_map();
  if (has_deviation) node.allow_only({"value", "sd"});
  const YamlNode given = has_deviation ? node.at("value") : node;
  value = read_value(given, dimension, units);
  constexpr double rounding = 1e-9;  // of a bound that has gone through other units
  if (!(value >= parameter.lower - rounding * std::abs(parameter.lower) &&
        value <= parameter.upper + rounding * std::abs(parameter.upper)))
    given.fail(fmt::format("{:.6g} is outside the physical range of '{}', {:.6g} to {:.6g} (SI)",
                           value, parameter.name, parameter.lower, parameter.upper));
  value = std::clamp(value, parameter.lower, parameter.upper);
  if (!has_deviation) return;
  if (const auto sd = node.find("sd")) {
    deviation = read_value(*sd, dimension, units);
    if (!(deviation >= 0)) sd->fail("a standard deviation must not be negative");
  }
}

// `a: {unit: N, between: [0, 100], prior: 10, none: 0}`, numbers in that unit.
EffectParameter read_parameter_kind(const YamlNode& node, const std::string& name) {
  node.allow_only({"unit", "between", "prior", "none"});
  spatial::Unit unit;
  if (const auto given = node.find("unit")) {
    try {
      unit = spatial::parse_unit(given->text());
    } catch (const std::invalid_argument& error) {
      given->fail(error.what());
    }
  }
  const YamlNode between = node.at("between");
  const std::vector<YamlNode> bounds = between.items(2);
  EffectParameter parameter{.name = name,
                            .linear = unit.dimension,
                            .angular = unit.dimension,
                            .lower = bounds[0].number() * unit.factor,
                            .upper = bounds[1].number() * unit.factor};
  if (!(parameter.lower < parameter.upper))
    between.fail("the physical range must run from a smaller to a larger number");
  const auto none = node.find("none");
  parameter.none = none ? none->number() * unit.factor : 0;
  const auto prior = node.find("prior");
  parameter.prior_sd =
      prior ? prior->number() * unit.factor : (parameter.upper - parameter.lower) / 4;
  if (!(parameter.prior_sd > 0))
    prior.value_or(between).fail("a prior standard deviation must be positive");
  return parameter;
}

// Names of variables must be new and be words.
void check_names(const YamlNode& node, std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto is_word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    };
    if (names[i].empty() || std::isdigit(static_cast<unsigned char>(names[i][0])) != 0 ||
        !std::all_of(names[i].begin(), names[i].end(), is_word))
      node.fail(fmt::format("'{}' cannot be the name of a variable", names[i]),
                "Use letters, digits and underscores");
    if (i > 0 && names[i] == names[i - 1])
      node.fail(fmt::format("'{}' already means something in the formula", names[i]),
                "x, d, u, t, T, fx, fy, fz, mx, my and mz are taken: choose another name");
  }
}

// `cable_drag: {force: "a * tanh(x / w)", parameters: {...}}`.
std::shared_ptr<const EffectKind> read_user_kind(const std::string& name, const YamlNode& node) {
  node.allow_only({"force", "offset", "compliance", "parameters", "covariates", "summary",
                   "signature", "confuser"});
  for (const auto& known : effect_kinds())
    if (known->name == name) node.fail(fmt::format("the catalogue has a '{}' already", name));
  const auto [law_name, formula] = node.one_of({"force", "offset", "compliance"});
  const effects::UserLaw law = law_name == "force"    ? effects::UserLaw::force
                               : law_name == "offset" ? effects::UserLaw::offset
                                                      : effects::UserLaw::compliance;
  std::vector<std::string> covariates;
  if (const auto list = node.find("covariates"))
    for (const YamlNode& item : list->items()) covariates.push_back(item.text());
  std::vector<EffectParameter> parameters;
  if (const auto map = node.find("parameters")) parameters = read_effect_parameters(*map);
  check_names(node, effects::user_variables(law, covariates, parameters));
  const Eigen::VectorXd typical = usual_values(parameters);
  try {
    const auto kind =
        effects::user_effect(law, formula.prose(), covariates, std::move(parameters), typical);
    const auto text = [&node](const char* key, const char* otherwise) {
      const auto given = node.find(key);
      return given ? given->prose() : std::string(otherwise);
    };
    kind->name = name;
    kind->summary = text("summary", "a formula of the robot file");
    kind->signature = text("signature", "not stated");
    kind->confuser = text("confuser", "not stated");
    return kind;
  } catch (const ExpressionError& error) {
    formula.fail(fmt::format("column {} of the formula: {}", error.column, error.what()),
                 fmt::format("{}\n{}^", formula.prose(),
                             std::string(static_cast<std::size_t>(error.column - 1), ' ')));
  }
}

std::shared_ptr<const EffectKind> read_kind(const YamlNode& item, const EffectKinds& kinds) {
  std::vector<std::string> names;
  for (const auto& kind : kinds) names.push_back(kind->name);
  const std::string name = item.at("effect").choice(names);
  return kinds[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) -
                                        names.begin())];
}

// Sites that are joints of one name must all turn, or all slide: their values share a unit.
void require_same_motion(const YamlNode& at, const Effect& effect, const Manipulator& manipulator) {
  for (const EffectSite& site : effect.sites) {
    Effect single = effect;
    single.sites = {site};
    if (turns(single, manipulator) != turns(effect, manipulator))
      at.fail(fmt::format("'{}' stands for joints that turn and joints that slide", effect.at),
              "Name the chain, too");
  }
}

Effect read_effect(const YamlNode& item, const EffectKinds& kinds, const Manipulator& manipulator,
                   const spatial::UnitSystem& units) {
  Effect effect;
  effect.kind = read_kind(item, kinds);
  std::vector<std::string> keys{"effect", "at"};
  for (const EffectParameter& parameter : effect.kind->parameters) keys.push_back(parameter.name);
  item.allow_only(keys);
  const auto count = static_cast<Eigen::Index>(effect.kind->parameters.size());
  effect.values = Eigen::VectorXd(count);
  effect.deviations = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
  const YamlNode at = item.at("at");
  effect.at = at.text();
  try {
    effect.sites = effect_sites(*effect.kind, manipulator, effect.at);
  } catch (const std::invalid_argument& error) {
    at.fail(error.what());
  }
  require_same_motion(at, effect, manipulator);
  const bool angular = turns(effect, manipulator);
  for (Eigen::Index p = 0; p < count; ++p) {
    const EffectParameter& parameter = effect.kind->parameters[static_cast<std::size_t>(p)];
    effect.values[p] = parameter.none;
    if (parameter.required || item.has(parameter.name))
      read_parameter(item.at(parameter.name), parameter, angular, units, effect.values[p],
                     effect.deviations[p]);
  }
  try {
    (void)with_effects(manipulator, {effect});
  } catch (const std::invalid_argument& error) {
    at.fail(error.what());
  }
  return effect;
}

// Of the value that is meant where none is named.
std::string leading_name(const std::string& kind, const EffectKinds& kinds) {
  const auto& parameters = effect_kind(kind, kinds)->parameters;
  if (parameters.empty())
    throw std::invalid_argument(fmt::format("the effect '{}' has no size: it is what it is", kind));
  return parameters.front().name;
}

}  // namespace

std::vector<EffectParameter> read_effect_parameters(const YamlNode& node) {
  std::vector<EffectParameter> parameters;
  for (const auto& [name, value] : node.members()) {
    parameters.push_back(read_parameter_kind(value, name));
    parameters.back().is_shape = parameters.size() > 1;
  }
  return parameters;
}

Eigen::VectorXd usual_values(const std::vector<EffectParameter>& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    values[static_cast<Eigen::Index>(p)] = std::clamp(parameters[p].none + parameters[p].prior_sd,
                                                      parameters[p].lower, parameters[p].upper);
  return values;
}

EffectKinds read_effect_kinds(const YamlNode& top, const EffectKinds& given) {
  EffectKinds kinds = given;
  if (const auto own = top.find("effect_kinds"))
    for (const auto& [name, node] : own->members()) {
      if (std::any_of(kinds.begin(), kinds.end(),
                      [&name = name](const auto& kind) { return kind->name == name; }))
        node.fail(fmt::format("another kind of effect is called '{}' already", name),
                  "Give each a name of its own");
      kinds.push_back(read_user_kind(name, node));
    }
  std::rotate(kinds.begin(), kinds.begin() + std::ssize(given), kinds.end());
  return kinds;
}

std::vector<Effect> read_effects(const YamlNode& top, const EffectKinds& kinds,
                                 const Manipulator& manipulator, const spatial::UnitSystem& units) {
  std::vector<Effect> effects;
  if (const auto list = top.find("effects"))
    for (const YamlNode& item : list->items())
      effects.push_back(read_effect(item, kinds, manipulator, units));
  return effects;
}

void read_effect_value(const YamlNode& node, const spatial::UnitSystem& units,
                       const Manipulator& manipulator, Eigen::Index parameter, Effect& effect) {
  read_parameter(node, effect.kind->parameters.at(static_cast<std::size_t>(parameter)),
                 turns(effect, manipulator), units, effect.values[parameter],
                 effect.deviations[parameter]);
}

Effect effect_from_words(const std::string& kind, const std::string& at, const std::string& size,
                         const EffectKinds& kinds, const Manipulator& manipulator,
                         const spatial::UnitSystem& units) {
  std::string text = fmt::format("effect: \"{}\"\nat: \"{}\"\n", kind, at);
  std::size_t begin = 0;
  while (begin < size.size()) {
    const std::size_t end = std::min(size.find(',', begin), size.size());
    const std::string word = size.substr(begin, end - begin);
    const std::size_t equals = word.find('=');
    const bool has_name = equals != std::string::npos;
    text +=
        fmt::format("{}: \"{}\"\n", has_name ? word.substr(0, equals) : leading_name(kind, kinds),
                    has_name ? word.substr(equals + 1) : word);
    begin = end + 1;
  }
  return read_effect(io::parse_yaml(text, "--effect " + kind), kinds, manipulator, units);
}

}  // namespace kinetostat::vjm
