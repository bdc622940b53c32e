#include "kinetostat/vjm/effects/effect.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/spelling.h"
#include "kinetostat/vjm/chain/chain_modifier.h"

namespace kinetostat::vjm {

using Eigen::Index;

double ChainState::drive_force(Index coordinate) const {
  double force = chain.stiffness()(coordinate, coordinate) * deflection[coordinate];
  for (const auto& [k, law] : chain.laws())
    if (k == coordinate && !law->is_beside_drive())
      force += chain.value_of(k, *law, x, deflection, travel).force;
  return force;
}

double ChainState::drive_stiffness(Index coordinate) const {
  double stiffness = chain.stiffness()(coordinate, coordinate);
  for (const auto& [k, law] : chain.laws())
    if (k == coordinate && !law->is_beside_drive())
      stiffness += chain.value_of(k, *law, x, deflection, travel).tangent;
  return stiffness;
}

void HistoryStep::start(const Eigen::Ref<const Eigen::VectorXd>& state, Index coordinates,
                        Index inputs) {
  next = state;
  by_coordinates.setZero(next.size(), coordinates);
  by_input.setZero(next.size(), inputs);
  by_drive_force.setZero(next.size());
}

void EffectKind::act(ChainModifier&, const std::string&, const EffectInput&) const {}
void EffectKind::differentiate(ChainColumns&, const std::string&, const EffectInput&) const {}
void EffectKind::add_to(ReadingErrors&, const EffectInput&) const {}
ReadingErrors EffectKind::tangent(Index, const EffectInput&) const {
  return ReadingErrors::tangent();
}
Lag EffectKind::lag(double, double, double) const {
  throw std::logic_error(fmt::format("the effect '{}' lags behind nothing", name));
}
bool EffectKind::is_off(const ReadingMoment&, const Eigen::VectorXd&) const { return false; }
bool EffectKind::turns_along(const Eigen::VectorXd&) const { return false; }
void EffectKind::advance(const ChainState&, const std::string&, const EffectInput&,
                         HistoryStep&) const {
  throw std::logic_error(fmt::format("the effect '{}' has no history", name));
}

std::shared_ptr<const EffectKind> effect_kind(const std::string& name, const EffectKinds& kinds) {
  std::vector<std::string> names;
  for (const auto& kind : kinds) {
    if (kind->name == name) return kind;
    names.push_back(kind->name);
  }
  const std::string near = common::nearest_spelling(name, names);
  throw std::invalid_argument(
      fmt::format("there is no effect '{}'{}", name,
                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

bool has_one_law(EffectClass effect_class) { return effect_class == EffectClass::friction; }

std::string to_string(EffectClass effect_class) {
  switch (effect_class) {
    case EffectClass::backlash:
      return "backlash";
    case EffectClass::stiffening:
      return "stiffens or softens under load";
    case EffectClass::friction:
      return "friction or hysteresis";
    case EffectClass::compliance:
      return "more compliance than the model has";
    case EffectClass::varying:
      return "stiffness that varies with the joint";
    case EffectClass::geometry:
      return "geometry";
    case EffectClass::preload:
      return "a preloaded spring";
    case EffectClass::weight:
      return "weight";
    case EffectClass::temperature:
      return "temperature";
    case EffectClass::time:
      return "creep or drift";
    case EffectClass::load:
      return "the load is not as stated";
    case EffectClass::instrument:
      return "the instrument";
    case EffectClass::other:
      break;
  }
  return "another effect";
}

std::string to_string(EffectPlace place) {
  static constexpr std::array names = {"joint", "link",     "element", "link/mass", "base",
                                       "end",   "platform", "load",    "sensor"};
  return names[static_cast<std::size_t>(place)];
}

Index Effect::history_size() const { return kind->history * static_cast<Index>(sites.size()); }

std::string Effect::name_of(Index value) const {
  return fmt::format("{} of {} at {}", kind->parameters[static_cast<std::size_t>(value)].name,
                     kind->name, at);
}

Histories no_history(const std::vector<Effect>& effects) {
  Histories histories;
  for (const Effect& effect : effects)
    histories.push_back(Eigen::VectorXd::Zero(effect.history_size()));
  return histories;
}

namespace {

// A link in segments has springs "leg.1", "leg.2", ...: the link is what is before the number.
std::string link_of(const std::string& spring) {
  const std::size_t dot = spring.rfind('.');
  const bool is_segment = dot != std::string::npos && dot + 1 < spring.size() &&
                          spring.find_first_not_of("0123456789", dot + 1) == std::string::npos;
  return is_segment ? spring.substr(0, dot) : spring;
}

void add_links(const Chain& chain, std::vector<std::string>& elements) {
  for (const Spring& spring : chain.springs()) {
    if (spring.stiffness.rows() != 6) continue;
    const std::string link = link_of(spring.name);
    if (std::find(elements.begin(), elements.end(), link) == elements.end())
      elements.push_back(link);
  }
}

// Links that have a mass, and masses that stand alone.
void add_masses(const Chain& chain, std::vector<std::string>& elements) {
  for (const PointMass& mass : chain.masses())
    if (!mass.element.empty() &&
        std::find(elements.begin(), elements.end(), mass.element) == elements.end())
      elements.push_back(mass.element);
}

void add_joints(const Chain& chain, std::vector<std::string>& elements) {
  for (const Coordinate& coordinate : chain.coordinates())
    if (coordinate.role != Role::elastic) elements.push_back(coordinate.name);
}

// The elements of one chain on which a kind can act, by name.
std::vector<std::string> elements_of(EffectPlace place, const Chain& chain) {
  std::vector<std::string> elements;
  if (place == EffectPlace::joint || place == EffectPlace::element) add_joints(chain, elements);
  if (place == EffectPlace::link || place == EffectPlace::element || place == EffectPlace::mass)
    add_links(chain, elements);
  if (place == EffectPlace::mass) add_masses(chain, elements);
  if (place == EffectPlace::base || place == EffectPlace::element) elements.push_back("base");
  if (place == EffectPlace::end || place == EffectPlace::element) elements.push_back("end");
  return elements;
}

// A chain whose end carries what is mounted on the platform, from the base where there is one.
std::optional<std::size_t> chain_to_platform(const Manipulator& manipulator) {
  std::optional<std::size_t> any;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    if (manipulator.span(c).to != Span::platform || manipulator.is_within_elastic_body(c)) continue;
    if (manipulator.span(c).from == Span::base) return c;
    if (!any) any = c;
  }
  return any;
}

// The place of a kind that is there once for several chains, if any.
struct SharedPlace {
  std::string name;
  EffectSite site;
};
std::optional<SharedPlace> shared_place(EffectPlace place, const Manipulator& manipulator) {
  if (place == EffectPlace::base && may_have_foundation(manipulator))
    return SharedPlace{"foundation", {SharedMounts::foundation, "base"}};
  if (place == EffectPlace::end && may_have_tool(manipulator))
    return SharedPlace{"tool", {SharedMounts::tool, "base"}};
  return std::nullopt;
}

bool is_of_robot(EffectPlace place) {
  return place == EffectPlace::platform || place == EffectPlace::load ||
         place == EffectPlace::sensor;
}

}  // namespace

namespace {

const char* const all_parts = "all parts";

bool acts_at(const EffectKind& kind, const Chain& chain, const std::string& element) {
  Eigen::VectorXd values(std::ssize(kind.parameters));
  for (Index k = 0; k < values.size(); ++k)
    values[k] = kind.parameters[static_cast<std::size_t>(k)].none;
  ChainModifier modifier(chain);
  try {
    kind.act(modifier, element, {values, {}, Eigen::VectorXd::Zero(kind.history)});
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

// Joints, links and ends of all chains.
std::vector<EffectSite> parts_of_all(const EffectKind& kind, const Manipulator& manipulator) {
  std::vector<EffectSite> sites;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Chain& chain = manipulator.chains()[c];
    if (manipulator.is_within_elastic_body(c)) continue;
    for (const std::string& element : elements_of(kind.place, chain))
      if (acts_at(kind, chain, element)) sites.push_back({c, element});
  }
  return sites;
}

}  // namespace

std::vector<std::string> effect_places(const EffectKind& kind, const Manipulator& manipulator) {
  if (is_of_robot(kind.place)) {
    if (kind.place == EffectPlace::platform && !chain_to_platform(manipulator)) return {};
    return {to_string(kind.place)};
  }
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    if (manipulator.is_within_elastic_body(c)) continue;
    const Chain& chain = manipulator.chains()[c];
    for (const std::string& element : elements_of(kind.place, chain)) {
      add(chain.name() + "." + element);
      add(element);
    }
  }
  if (const auto shared = shared_place(kind.place, manipulator)) add(shared->name);
  if (kind.acts_on_all && parts_of_all(kind, manipulator).size() > 1) add(all_parts);
  return names;
}

std::vector<EffectSite> effect_sites(const EffectKind& kind, const Manipulator& manipulator,
                                     const std::string& name) {
  std::vector<EffectSite> sites;
  for (std::size_t c = 0; c < manipulator.size() && !is_of_robot(kind.place); ++c) {
    if (manipulator.is_within_elastic_body(c)) continue;
    const Chain& chain = manipulator.chains()[c];
    for (const std::string& element : elements_of(kind.place, chain))
      if (name == element || name == chain.name() + "." + element) sites.push_back({c, element});
  }
  if (!sites.empty()) return sites;
  if (kind.acts_on_all && name == all_parts) return parts_of_all(kind, manipulator);
  const auto shared = shared_place(kind.place, manipulator);
  if (shared && shared->name == name) return {shared->site};
  const std::vector<std::string> known = effect_places(kind, manipulator);
  if (is_of_robot(kind.place) && std::find(known.begin(), known.end(), name) != known.end()) {
    if (kind.place != EffectPlace::platform) return {};
    return {{*chain_to_platform(manipulator), {}}};
  }
  for (const ElasticBody& body : manipulator.elastic_bodies())
    if (body.name == name)
      throw std::invalid_argument(fmt::format(
          "'{}' is an elastic body, and effects act on joints and links of chains", name));
  if (known.empty())
    throw std::invalid_argument(fmt::format("the robot has no {} on which '{}' could act",
                                            to_string(kind.place), kind.name));
  const std::string near = common::nearest_spelling(name, known);
  throw std::invalid_argument(
      fmt::format("'{}' is no {} of this robot{}", name, to_string(kind.place),
                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

bool turns(const Effect& effect, const Manipulator& manipulator) {
  if (effect.kind->place != EffectPlace::joint || effect.sites.empty()) return false;
  const Chain& chain = manipulator.chains()[effect.sites[0].chain];
  return is_rotation(
      chain.coordinates()[static_cast<std::size_t>(chain.index_of(effect.sites[0].element))]
          .motion);
}

namespace {

// Compliance of the softest spring of a joint [rad/(N m), or m/N].
double softest(const Manipulator& manipulator, bool angular) {
  constexpr double lever2 = 0.3 * 0.3;
  double largest = 0;
  for (const Chain& chain : manipulator.chains())
    for (const Spring& spring : chain.springs()) {
      if (spring.stiffness.rows() != 1 || !(spring.stiffness(0, 0) > 0)) continue;
      const bool turns =
          is_rotation(chain.coordinates()[static_cast<std::size_t>(spring.first)].motion);
      const double same_sort = turns == angular ? 1 : angular ? 1 / lever2 : lever2;
      largest = std::max(largest, same_sort / spring.stiffness(0, 0));
    }
  return largest > 0 ? largest : angular ? 1e-6 : 1e-8;
}

}  // namespace

namespace {

// The largest of its sites.
JointScale scale_of(const Effect& effect, const Manipulator& bare, const ReadingScales& scales) {
  if (scales.joints.empty()) return {};
  JointScale largest{.load = 0, .travel = 0, .play = 0};
  for (const EffectSite& site : effect.sites) {
    const Index k = bare.chains()[site.chain].index_of(site.element);
    const JointScale& scale = scales.joints[site.chain][static_cast<std::size_t>(k)];
    largest.load = std::max(largest.load, scale.load);
    largest.travel = std::max(largest.travel, scale.travel);
    largest.play = std::max(largest.play, scale.play);
    largest.span = std::max(largest.span, scale.span);
  }
  return largest;
}

// Of those that no place gives.
std::optional<double> prior_deviation_of_readings(const EffectParameter& parameter,
                                                  const ReadingScales& scales) {
  const double share = parameter.prior_sd;
  const double change = parameter.linear.angle != 0 ? scales.turn : scales.shift;
  switch (parameter.prior_unit) {
    case PriorUnit::change_read:
      return share * change;
    case PriorUnit::change_in_session:
      return share * change / scales.session;
    case PriorUnit::stated_force:
      return share * scales.force;
    case PriorUnit::stated_moment:
      return share * scales.moment;
    case PriorUnit::per_force_squared:
      return share / (scales.force * scales.force);
    case PriorUnit::per_moment_squared:
      return share / (scales.moment * scales.moment);
    default:
      return std::nullopt;
  }
}

}  // namespace

double prior_deviation(const Effect& effect, Index value, const Manipulator& bare,
                       const ReadingScales& scales) {
  const EffectParameter& parameter = effect.kind->parameters[static_cast<std::size_t>(value)];
  const double share = parameter.prior_sd;
  if (parameter.prior_unit == PriorUnit::soft_compliance)
    return share * softest(bare, parameter.linear.angle != 0);
  if (const auto known = prior_deviation_of_readings(parameter, scales)) return *known;
  if (parameter.prior_unit == PriorUnit::absolute || effect.sites.empty()) return share;
  const Chain& chain = bare.chains()[effect.sites[0].chain];
  const Index k = chain.index_of(effect.sites[0].element);
  const double stiffness = chain.stiffness()(k, k);
  const JointScale scale = scale_of(effect, bare, scales);
  switch (parameter.prior_unit) {
    case PriorUnit::joint_load:
      return share * scale.load;
    case PriorUnit::joint_play:
      return share * scale.play;
    case PriorUnit::cubic_stiffness:
      return share * stiffness / (scale.travel * scale.travel);
    case PriorUnit::load_compliance:
      return share / stiffness / scale.load;
    case PriorUnit::per_joint_span:
      return share / scale.span;
    case PriorUnit::stiffness:
      return share * stiffness;
    default:
      return share / stiffness;
  }
}

std::vector<std::size_t> in_order(const std::vector<Effect>& effects) {
  const auto rank = [](const Effect& effect) {
    const auto& kinds = effect_kinds();
    return std::find(kinds.begin(), kinds.end(), effect.kind) - kinds.begin();
  };
  std::vector<std::size_t> order(effects.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (order.size() == 1) return order;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rank(effects[a]) < rank(effects[b]);
  });
  return order;
}

bool act_on(std::size_t chain, const std::vector<Effect>& effects) {
  return std::any_of(effects.begin(), effects.end(), [&](const Effect& effect) {
    return std::any_of(effect.sites.begin(), effect.sites.end(),
                       [&](const EffectSite& site) { return site.chain == chain; });
  });
}

void put_on(std::size_t chain, const Effect& effect, const Conditions& conditions,
            const Eigen::VectorXd& history, ChainModifier& modifier) {
  const Index size = effect.kind->history;
  Eigen::VectorXd own;
  for (std::size_t s = 0; s < effect.sites.size(); ++s) {
    if (effect.sites[s].chain != chain) continue;
    const bool is_all = history.size() == size;
    if (!is_all) own = history.segment(static_cast<Index>(s) * size, size);
    effect.kind->act(modifier, effect.sites[s].element,
                     {effect.values, conditions, is_all ? history : own});
  }
}

namespace {

// What a mount, which has no springs of its own, is stiff beside: those of all chains; where none
// of them slides, or turns, the others at a lever of 0.3 m.
void stand_beside_all(const Manipulator& manipulator, ChainModifier& mount) {
  constexpr double lever2 = 0.3 * 0.3;  // [m^2]
  double linear = 0, angular = 0;
  for (const Chain& chain : manipulator.chains())
    for (Index k = 0; k < chain.size(); ++k) {
      double& most =
          is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion) ? angular : linear;
      most = std::max(most, chain.stiffness()(k, k));
    }
  mount.stand_beside(linear > 0 ? linear : angular / lever2,
                     angular > 0 ? angular : linear * lever2);
}

}  // namespace

SharedMounts mounts_of(const std::vector<Effect>& effects) {
  SharedMounts mounts;
  for (const Effect& effect : effects)
    for (const EffectSite& site : effect.sites) {
      mounts.has_foundation |= site.chain == SharedMounts::foundation;
      mounts.has_tool |= site.chain == SharedMounts::tool;
    }
  return mounts;
}

std::vector<Effect> on_mounts(const SharedMounts& mounts, const Manipulator& without,
                              std::vector<Effect> effects) {
  for (Effect& effect : effects)
    for (EffectSite& site : effect.sites) {
      const bool is_on_tool = mounts.has_tool && effect.kind->place == EffectPlace::platform;
      site.chain = mounts.chain(is_on_tool ? SharedMounts::tool : site.chain, without);
    }
  return effects;
}

Manipulator with_effects(const Manipulator& manipulator, const std::vector<Effect>& effects,
                         const Conditions& conditions, const Histories& histories) {
  if (effects.empty()) return manipulator;
  if (const SharedMounts mounts = mounts_of(effects); mounts.any())
    return with_effects(mounts.on(manipulator), on_mounts(mounts, manipulator, effects), conditions,
                        histories);
  const std::vector<std::size_t> order = in_order(effects);
  std::vector<Chain> chains;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    chains.push_back(manipulator.chains()[c]);
    if (!act_on(c, effects)) continue;
    ChainModifier modifier(std::move(chains.back()));
    if (modifier.chain().size() == 0) stand_beside_all(manipulator, modifier);
    for (const std::size_t e : order) put_on(c, effects[e], conditions, histories[e], modifier);
    chains.back() = std::move(modifier).chain();
  }
  return manipulator.with_chains(std::move(chains));
}

Manipulator with_effects(const Manipulator& manipulator, const std::vector<Effect>& effects) {
  return with_effects(manipulator, effects, {}, no_history(effects));
}

bool can_act(const Effect& effect, const Manipulator& bare) {
  try {
    (void)with_effects(bare, {effect});
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

std::vector<std::string> acting_places(const std::shared_ptr<const EffectKind>& kind,
                                       const Manipulator& manipulator) {
  const auto is_usual_at = [&](const std::string& place) {
    Effect effect{.kind = kind,
                  .at = place,
                  .sites = effect_sites(*kind, manipulator, place),
                  .values = Eigen::VectorXd(static_cast<Eigen::Index>(kind->parameters.size()))};
    Eigen::Index k = 0;
    for (const EffectParameter& parameter : kind->parameters) {
      const double usual = k == 0 || parameter.required
                               ? parameter.none + prior_deviation(effect, k, manipulator)
                               : parameter.none;
      effect.values[k++] = std::clamp(usual, parameter.lower, parameter.upper);
    }
    return vjm::can_act(effect, manipulator);
  };
  std::vector<std::string> places = effect_places(*kind, manipulator);
  std::erase_if(places, [&](const std::string& place) { return !is_usual_at(place); });
  return places;
}

bool acts_under(const EffectKind& kind, const Conditions& conditions) {
  if (kind.place == EffectPlace::load && conditions.known_load) return false;
  return !kind.by_temperature || conditions.temperature;
}

ReadingErrors reading_errors(const std::vector<Effect>& effects, const Conditions& conditions) {
  ReadingErrors errors;
  const Eigen::VectorXd none;
  for (const Effect& effect : effects)
    if (!effect.kind->acts_on_chains() && acts_under(*effect.kind, conditions))
      effect.kind->add_to(errors, {effect.values, conditions, none});
  return errors;
}

}  // namespace kinetostat::vjm
