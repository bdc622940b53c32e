#include "kinetostat/report/effect.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kinetostat::report {

std::string prior_unit(const vjm::EffectParameter& parameter) {
  switch (parameter.prior_unit) {
    case vjm::PriorUnit::stiffness:
      return "times the stiffness of the joint's spring";
    case vjm::PriorUnit::compliance:
      return "over the stiffness of the joint's spring";
    case vjm::PriorUnit::joint_load:
      return "times what the readings load the joint with";
    case vjm::PriorUnit::joint_play:
      return "times the motion of the joint that would show as much as the readings do";
    case vjm::PriorUnit::cubic_stiffness:
      return "times the stiffness of the joint's spring over the square of how far the readings "
             "deflect it";
    case vjm::PriorUnit::load_compliance:
      return "over the stiffness of the joint's spring and what the readings load it with";
    case vjm::PriorUnit::per_joint_span:
      return "over the range of the joint's commands in the readings";
    case vjm::PriorUnit::change_read:
      return "times the largest change that is read";
    case vjm::PriorUnit::change_in_session:
      return "times the largest change that is read, in the time of a session";
    case vjm::PriorUnit::stated_force:
      return "times the largest force that is stated";
    case vjm::PriorUnit::stated_moment:
      return "times the largest moment that is stated";
    case vjm::PriorUnit::per_force_squared:
      return "over the square of the largest force that is stated";
    case vjm::PriorUnit::per_moment_squared:
      return "over the square of the largest moment that is stated";
    case vjm::PriorUnit::soft_compliance:
      return "times the compliance of the softest joint, at a lever of 0.3 m where the one shifts "
             "and the other turns";
    default:
      return "SI";
  }
}

std::string unit_of(const vjm::EffectParameter& parameter, bool angular) {
  const spatial::Dimension& dimension = angular ? parameter.angular : parameter.linear;
  return dimension == spatial::dimension::none ? "" : spatial::to_string(dimension);
}

std::string places_text(const std::shared_ptr<const vjm::EffectKind>& kind,
                        const vjm::Robot& robot) {
  const auto places = vjm::acting_places(kind, robot.without_effects());
  if (places.empty()) return fmt::format("'{}' has no place for it.\n", robot.name);
  return fmt::format("In '{}' it can act at: {}.\n", robot.name, fmt::join(places, ", "));
}

namespace {

io::Json to_json(const vjm::EffectParameter& p) {
  return {{"name", p.name},
          {"unit_linear", spatial::to_string(p.linear)},
          {"unit_angular", spatial::to_string(p.angular)},
          {"lower", p.lower},
          {"upper", p.upper},
          {"none", p.none},
          {"prior_sd", p.prior_sd},
          {"prior_unit", prior_unit(p)},
          {"required", p.required}};
}

}  // namespace

io::Json to_json(const vjm::EffectKind& kind) {
  io::Json parameters = io::Json::array();
  for (const vjm::EffectParameter& p : kind.parameters) parameters.push_back(to_json(p));
  return {{"name", kind.name},
          {"summary", kind.summary},
          {"acts_on", vjm::to_string(kind.place)},
          {"law", kind.law},
          {"source", kind.source},
          {"signature", kind.signature},
          {"confuser", kind.confuser},
          {"parameters", parameters}};
}

}  // namespace kinetostat::report
