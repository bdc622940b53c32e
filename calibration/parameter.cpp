#include "kinetostat/calibration/parameter.h"

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

std::string Parameter::phrase() const { return "the stiffness of '" + name + "'"; }

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
    describe_stiffness(robot.manipulator, parameter);
    parameters.push_back(std::move(parameter));
  }
  return parameters;
}

vjm::Manipulator with_values(const vjm::Manipulator& manipulator,
                             const std::vector<Parameter>& parameters,
                             const Eigen::VectorXd& values) {
  vjm::Manipulator result = manipulator;
  for (std::size_t p = 0; p < parameters.size(); ++p)
    result = vjm::with_scaled(result, {parameters[p].name, parameters[p].springs},
                              std::exp(values[static_cast<Eigen::Index>(p)]));
  return result;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> pose_derivatives(
    const vjm::Manipulator& manipulator, const vjm::Posture& posture, const vjm::Load& load,
    const vjm::Equilibrium& equilibrium, const std::vector<Parameter>& parameters) {
  std::vector<vjm::SpringParameter> springs;
  for (const Parameter& parameter : parameters)
    springs.insert(springs.end(), parameter.springs.begin(), parameter.springs.end());
  const auto by_spring =
      vjm::displacement_by_log_stiffness(manipulator, posture, load, equilibrium, springs);
  Eigen::Matrix<double, 6, Eigen::Dynamic> result(6, parameters.size());
  Eigen::Index first = 0;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto count = static_cast<Eigen::Index>(parameters[p].springs.size());
    result.col(static_cast<Eigen::Index>(p)) = by_spring.middleCols(first, count).rowwise().sum();
    first += count;
  }
  return result;
}

}  // namespace kinetostat::calibration
