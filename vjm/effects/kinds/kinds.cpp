#include "kinetostat/vjm/effects/kinds/kinds.h"

#include <numbers>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"

namespace kinetostat::vjm {

using Eigen::Index;

namespace effects {

EffectParameter optional_parameter(std::string name, const spatial::Dimension& dimension,
                                   double limit, double prior_sd) {
  return {.name = std::move(name),
          .linear = dimension,
          .angular = dimension,
          .lower = -limit,
          .upper = limit,
          .prior_sd = prior_sd,
          .required = false};
}

EffectParameter either_way(std::string name, std::string words) {
  EffectParameter parameter = optional_parameter(std::move(name), spatial::dimension::none, 1, 1);
  parameter.lower = 0;
  parameter.is_shape = true;
  parameter.usual_linear = parameter.usual_angular = {0, 1};
  parameter.usual_in_words = {"", std::move(words)};
  return parameter;
}

EffectParameter settled_weight() {
  EffectParameter parameter = either_way("settled", "its weight settled before");
  parameter.is_of_weight = true;
  return parameter;
}

EffectParameter added_compliance(std::string name, const spatial::Dimension& dimension) {
  return {.name = std::move(name),
          .linear = dimension,
          .angular = dimension,
          .lower = 0,
          .upper = 1,
          .prior_sd = 0.1,
          .prior_unit = PriorUnit::soft_compliance,
          .required = false};
}

EffectParameter order_of_ripple(std::vector<double> of_turn) {
  constexpr double turn = 2 * std::numbers::pi;
  return {.name = "order",
          .linear = {.length = -1, .angle = 1},
          .angular = spatial::dimension::none,
          .lower = 1e-3,
          .upper = 1e6,
          .prior_sd = 1,
          .none = 1,
          .required = false,
          .is_shape = true,
          .is_order = true,
          .usual_linear = {turn / 0.005, turn / 0.01, turn / 0.02},
          .usual_angular = std::move(of_turn)};
}

EffectParameter lag_of_temperature() {
  return {.name = "lag",
          .linear = spatial::dimension::time,
          .angular = spatial::dimension::time,
          .lower = 0,
          .upper = 1e6,
          .prior_sd = 1800,
          .required = false,
          .is_shape = true};
}

Warming warming(const Conditions& conditions, double reference, double lag) {
  if (!conditions.temperature) return {};
  const TemperatureLag lagged = temperature_lag(conditions.past, lag);
  return {*conditions.temperature + lagged.behind - reference, lagged.by_lag};
}

double home_of(const Chain& chain, Index coordinate) {
  return chain.coordinates()[static_cast<std::size_t>(coordinate)].home;
}

void lead_by_ratio(ChainModifier& modifier, Index k, Index leader, double ratio) {
  modifier.add_transmission_error({.coordinate = k,
                                   .leader = leader,
                                   .ratio = ratio,
                                   .from = home_of(modifier.chain(), leader)});
}

void add_ratio(ChainColumns& columns, Index column, Index k, Index leader) {
  const ChainState& state = columns.state();
  const double command = state.x[leader] - state.travel[leader];
  columns.add_transmission_error(column, k, command - home_of(state.chain, leader));
}

const Spring& spring_of_joint(const Chain& chain, const std::string& joint) {
  const Index k = chain.index_of(joint);
  for (const Spring& spring : chain.springs())
    if (spring.first == k && spring.stiffness.rows() == 1) return spring;
  throw std::invalid_argument(
      fmt::format("joint '{}' of chain '{}' has no spring", joint, chain.name()));
}

}  // namespace effects

const EffectKinds& effect_kinds() {
  static const EffectKinds kinds = {effects::joint_compliance(),
                                    effects::link_compliance(),
                                    effects::bearing_compliance(),
                                    effects::bearing_tilt(),
                                    effects::base_compliance(),
                                    effects::base_tilt(),
                                    effects::platform_compliance(),
                                    effects::geometric_error(),
                                    effects::joint_offset(),
                                    effects::thermal_expansion(),
                                    effects::eccentricity(),
                                    effects::transmission_ratio(),
                                    effects::joint_coupling(),
                                    effects::creep(),
                                    effects::hardening(),
                                    effects::load_hardening(),
                                    effects::piecewise_stiffness(),
                                    effects::directional_stiffness(),
                                    effects::opening_contact(),
                                    effects::periodic_stiffness(),
                                    effects::stiffness_along_joint(),
                                    effects::thermal_softening(),
                                    effects::clearance(),
                                    effects::biased_clearance(),
                                    effects::friction(),
                                    effects::load_friction(),
                                    effects::preload(),
                                    effects::gravity_compensator(),
                                    effects::self_weight(),
                                    effects::payload(),
                                    effects::wrench_gain(),
                                    effects::wrench_misalignment(),
                                    effects::wrench_zero(),
                                    effects::wrench_channel_gain(),
                                    effects::wrench_saturation(),
                                    effects::application_point(),
                                    effects::sensor_frame(),
                                    effects::sensor_scale(),
                                    effects::sensor_axis_scale(),
                                    effects::target_lever_arm(),
                                    effects::session_drift(),
                                    effects::gauge_play(),
                                    effects::target_slip(),
                                    effects::cycle_offset()};
  return kinds;
}

}  // namespace kinetostat::vjm
