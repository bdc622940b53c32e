#include "kinetostat/calibration/regression/parameter.h"

#include <algorithm>
#include <cmath>

namespace kinetostat::calibration {
namespace {

const vjm::Spring& spring_of(const vjm::Manipulator& manipulator,
                             const vjm::SpringParameter& parameter) {
  const std::vector<vjm::Spring>& springs = manipulator.chains().at(parameter.chain).springs();
  return *std::find_if(springs.begin(), springs.end(),
                       [&](const vjm::Spring& spring) { return spring.name == parameter.spring; });
}

void describe_stiffness(const vjm::Manipulator& manipulator, Parameter& parameter) {
  for (const vjm::SpringParameter& place : parameter.springs) {
    const vjm::Spring& spring = spring_of(manipulator, place);
    const double stiffness = spring.stiffness(0, 0);
    const auto& coordinate =
        manipulator.chains()[place.chain].coordinates()[static_cast<std::size_t>(spring.first)];
    const bool same =
        !parameter.stiffness || (*parameter.stiffness == stiffness &&
                                 parameter.is_torsional == vjm::is_rotation(coordinate.motion));
    if (spring.stiffness.rows() > 1 || !same) {
      parameter.stiffness.reset();
      return;
    }
    parameter.stiffness = stiffness;
    parameter.is_torsional = vjm::is_rotation(coordinate.motion);
  }
}

}  // namespace

std::string Parameter::phrase() const {
  return is_logarithm() ? "the stiffness of '" + name + "'" : "the " + name;
}

Parameter effect_parameter(const std::vector<vjm::Effect>& effects, std::size_t index,
                           Eigen::Index value, const vjm::Manipulator& bare) {
  const vjm::Effect& effect = effects.at(index);
  const vjm::EffectParameter& described =
      effect.kind->parameters.at(static_cast<std::size_t>(value));
  const double prior = vjm::prior_deviation(effect, value, bare);
  return {
      .name = effect.name_of(value),
      .springs = {},
      .stiffness = {},
      .start = effect.values[value],
      .lower = described.lower,
      .upper = described.upper,
      .longest_step = 3 * std::max(prior, std::abs(effect.values[value])),
      .bounds_stated = true,
      .unit = spatial::to_string(vjm::turns(effect, bare) ? described.angular : described.linear),
      .typical = std::max(prior, std::abs(effect.values[value])),
      .effect = index,
      .value = value};
}

Eigen::VectorXd starts_of(const std::vector<Parameter>& parameters) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    values[static_cast<Eigen::Index>(k)] = parameters[k].start;
  return values;
}

std::vector<Parameter> uncertain_parameters(const vjm::Robot& robot) {
  std::vector<Parameter> parameters;
  for (const vjm::UncertainStiffness& uncertain : robot.uncertain) {
    Parameter parameter{.name = uncertain.name, .springs = uncertain.springs, .stiffness = {}};
    if (uncertain.between) {
      parameter.lower = std::log(uncertain.between->first);
      parameter.upper = std::log(uncertain.between->second);
      parameter.start = std::clamp(0.0, parameter.lower, parameter.upper);
      parameter.bounds_stated = true;
    }
    describe_stiffness(robot.without_effects(), parameter);
    parameters.push_back(std::move(parameter));
  }
  for (const vjm::UncertainValue& uncertain : robot.uncertain_values)
    parameters.push_back(effect_parameter(robot.effects, uncertain.effect, uncertain.value,
                                          robot.without_effects()));
  return parameters;
}

vjm::EffectModel with_values(const vjm::Manipulator& bare, std::vector<vjm::Effect> effects,
                             const std::vector<Parameter>& parameters,
                             const Eigen::VectorXd& values) {
  vjm::Manipulator scaled = bare;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const double value = values[static_cast<Eigen::Index>(p)];
    if (parameters[p].is_logarithm())
      scaled =
          vjm::with_scaled(scaled, {parameters[p].name, parameters[p].springs}, std::exp(value));
    else
      effects.at(parameters[p].effect).values[parameters[p].value] = value;
  }
  return {std::move(scaled), std::move(effects)};
}

std::vector<vjm::ModelParameter> model_parameters(const std::vector<Parameter>& parameters) {
  std::vector<vjm::ModelParameter> result;
  result.reserve(parameters.size());
  for (const Parameter& parameter : parameters)
    result.push_back({parameter.springs, parameter.effect, parameter.value});
  return result;
}

}  // namespace kinetostat::calibration
