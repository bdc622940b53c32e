// Parameters that a base fit may change in a model: the only file that knows their kinds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/vjm/effects/effect_model.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::calibration {

/// Springs of one name, scaled together, or a value of an effect. The coordinate of the former is
/// ln(stiffness / nominal stiffness); the latter is its own coordinate, in SI.
struct Parameter {
  std::string name;  // as in the robot file: "leg", or "x.rho"; "k3 of hardening at x.rho"
  std::vector<vjm::SpringParameter> springs;
  /// Nominal stiffness, where all the springs are one-dimensional and equal [N/m or N m/rad].
  std::optional<double> stiffness;
  bool is_torsional = false;

  // Start of the fit, bounds and longest step of the coordinate.
  double start = 0, lower = -runaway, upper = runaway, longest_step = 1;
  /// The bounds mean something: the user or physics sets them. Otherwise a fit that hits one
  /// diverges.
  bool bounds_stated = false;
  /// It is held because the readings do not distinguish it from what is fitted.
  bool is_confounded = false;
  std::string unit = {};  // of the coordinate, SI; empty for a logarithm
  double typical = 1;     // a change of it that is worth knowing
  /// Knowledge of the coordinate beside the readings; it enters the fit as one more reading.
  struct Prior {
    double mean = 0, deviation = 1;
    /// Priors of one group are known up to a common factor (evidence.h); -1: there is none.
    int group = -1;
    double times = 1;  // the usual deviation: how much wider the prior of a group is
  };
  std::optional<Prior> prior = {};

  // Which value of which effect of the model, when there are no springs.
  std::size_t effect = 0;
  Eigen::Index value = 0;

  /// A stiffness factor beyond e^10 either way: the data want the spring rigid, or gone.
  static constexpr double runaway = 10;

  bool is_logarithm() const { return !springs.empty(); }
  bool is_held() const { return lower == upper; }  // it stays where it starts
  std::string phrase() const;  // "the stiffness of 'leg'", "the k3 of hardening at x.rho"
};

/// The coordinate of an effect's value: it starts where the effect stands and stays in its physical
/// range. `bare` is the manipulator without effects.
Parameter effect_parameter(const std::vector<vjm::Effect>& effects, std::size_t effect,
                           Eigen::Index value, const vjm::Manipulator& bare);

/// Where a fit of them starts, in their order.
Eigen::VectorXd starts_of(const std::vector<Parameter>& parameters);

/// The parameters that the robot file declares uncertain.
std::vector<Parameter> uncertain_parameters(const vjm::Robot& robot);

/// The model with its parameters at `values`.
vjm::EffectModel with_values(const vjm::Manipulator& bare, std::vector<vjm::Effect> effects,
                             const std::vector<Parameter>& parameters,
                             const Eigen::VectorXd& values);

/// The same parameters as the model's equations know them.
std::vector<vjm::ModelParameter> model_parameters(const std::vector<Parameter>& parameters);

}  // namespace kinetostat::calibration
