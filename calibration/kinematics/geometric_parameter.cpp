#include "kinetostat/calibration/kinematics/geometric_parameter.h"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

constexpr char displacement_kind[] = "geometric_error", ratio_kind[] = "transmission_ratio";

// A place of a chain that can have an error.
struct Place {
  std::size_t chain = 0;
  std::string element;
  GeometryGroup group = GeometryGroup::link;
  std::optional<Index> own_axis = {};  // the component along the axis of the joint there
  bool is_actuated = false;

  // A screw has a lead, a linear scale a pitch; the teeth of a gear are counted.
  bool can_be_out_of_scale() const { return is_actuated && own_axis && *own_axis < 3; }
};

std::vector<Place> places_of(const vjm::Manipulator& bare) {
  std::vector<Place> places;
  for (std::size_t c = 0; c < bare.size(); ++c) {
    if (bare.is_within_elastic_body(c)) continue;
    places.push_back({c, "base", GeometryGroup::base});
    for (const vjm::Coordinate& joint : bare.chains()[c].coordinates())
      if (joint.role != vjm::Role::elastic)
        places.push_back({c, joint.name, GeometryGroup::link, static_cast<Index>(joint.motion),
                          joint.role == vjm::Role::actuated});
    places.push_back({c, "end", GeometryGroup::tool});
  }
  return places;
}

// The effect of a kind that a place has already, by itself.
std::optional<std::size_t> effect_at(const std::vector<vjm::Effect>& effects,
                                     const std::string& kind, const Place& place) {
  for (std::size_t e = 0; e < effects.size(); ++e)
    if (effects[e].kind->name == kind && effects[e].sites.size() == 1 &&
        effects[e].sites[0].chain == place.chain && effects[e].sites[0].element == place.element)
      return e;
  return std::nullopt;
}

std::size_t add_effect(const vjm::Robot& robot, const std::string& kind, const Place& place,
                       std::vector<vjm::Effect>& effects) {
  if (const auto known = effect_at(effects, kind, place)) return *known;
  const std::string& chain = robot.without_effects().chains()[place.chain].name();
  const std::shared_ptr<const vjm::EffectKind> found = vjm::effect_kind(kind, robot.kinds());
  effects.push_back({.kind = found,
                     .at = chain + "." + place.element,
                     .sites = {{place.chain, place.element}},
                     .values = Eigen::VectorXd::Zero(std::ssize(found->parameters))});
  return effects.size() - 1;
}

std::string name_of(const Place& place, const vjm::Manipulator& bare) {
  if (bare.size() > 1) return bare.chains()[place.chain].name() + "." + place.element;
  return place.group == GeometryGroup::base   ? "the base"
         : place.group == GeometryGroup::tool ? "the tool"
                                              : place.element;
}

}  // namespace

std::string to_string(GeometryGroup group) {
  static constexpr std::array names = {"base", "tool", "joint offset", "link", "drive"};
  return names[static_cast<std::size_t>(group)];
}

std::string GeometricParameter::unit() const {
  return group == GeometryGroup::drive ? "" : turns() ? "rad" : "m";
}

std::string GeometricParameter::phrase() const {
  if (group == GeometryGroup::joint_offset) return "the offset of " + place;
  if (group == GeometryGroup::drive) return "the scale of " + place;
  return fmt::format("the {} {} {} {} {}", turns() ? "turn" : "shift",
                     group == GeometryGroup::link ? "behind" : "of", place,
                     turns() ? "about" : "along", axis());
}

GeometricModel geometric_model(const vjm::Robot& robot, const Tolerance& tolerance) {
  const vjm::Manipulator& bare = robot.without_effects();
  GeometricModel model{.effects = robot.effects, .parameters = {}};
  for (const Place& place : places_of(bare)) {
    const std::size_t effect = add_effect(robot, displacement_kind, place, model.effects);
    for (Index k = 0; k < 6; ++k) {
      const bool is_own = place.own_axis == k;
      if (is_own && !place.is_actuated) continue;
      model.parameters.push_back({.group = is_own ? GeometryGroup::joint_offset : place.group,
                                  .at = model.effects[effect].at,
                                  .place = name_of(place, bare),
                                  .effect = effect,
                                  .component = k,
                                  .tolerance = k < 3 ? tolerance.length : tolerance.angle});
    }
    if (place.can_be_out_of_scale())
      model.parameters.push_back({.group = GeometryGroup::drive,
                                  .at = model.effects[effect].at,
                                  .place = name_of(place, bare),
                                  .effect = add_effect(robot, ratio_kind, place, model.effects),
                                  .component = 0,
                                  .tolerance = tolerance.ratio()});
  }
  std::stable_sort(model.parameters.begin(), model.parameters.end(),
                   [](const auto& a, const auto& b) { return a.group < b.group; });
  return model;
}

std::vector<Parameter> fit_parameters(const GeometricModel& model, const vjm::Manipulator& bare) {
  constexpr double longest_step = 0.03;  // [m or rad]: where small displacements are still that
  std::vector<Parameter> parameters;
  for (const GeometricParameter& p : model.parameters) {
    parameters.push_back(effect_parameter(model.effects, p.effect, p.component, bare));
    parameters.back().name = p.phrase().substr(4);  // its own phrase() puts "the" before it
    parameters.back().longest_step = longest_step;
    parameters.back().typical = p.tolerance;
  }
  return parameters;
}

}  // namespace kinetostat::calibration
