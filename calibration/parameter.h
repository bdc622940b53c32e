// What a base fit may change in a model: the only file that knows the kinds of parameters.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/vjm/robot_file.h"

namespace kinetostat::calibration {

/// Springs of one name, scaled together. The coordinate in which it is fitted is the natural
/// logarithm of the factor: 0 as designed.
struct Parameter {
  std::string name;  // as in the robot file: "leg", or "x.rho"
  std::vector<vjm::SpringParameter> springs;
  /// Stiffness as designed, where all the springs are one-dimensional and equal [N/m or N m/rad].
  std::optional<double> stiffness;
  bool is_torsional = false;

  // Of the coordinate: where the fit starts, its bounds, and its longest step.
  double start = 0, lower = -runaway, upper = runaway, longest_step = 1;
  /// The bounds mean something: the user or physics sets them. Otherwise a fit that hits one is
  /// running away.
  bool bounds_stated = false;
  std::string unit = {};  // of the coordinate, SI; empty for a logarithm
  double typical = 1;     // a change of it that is worth knowing
  /// What is known of the coordinate beside the readings; enters the fit as one more reading.
  struct Prior {
    double mean = 0, deviation = 1;
  };
  std::optional<Prior> prior = {};

  /// A stiffness factor beyond e^10 either way: the data want the spring rigid, or gone.
  static constexpr double runaway = 10;

  bool is_logarithm() const { return !springs.empty(); }
  std::string phrase() const;  // "the stiffness of 'leg'"
};

/// What the robot file declares uncertain.
std::vector<Parameter> uncertain_parameters(const vjm::Robot& robot);

/// The manipulator with its parameters at `values` (one logarithm each).
vjm::Manipulator with_values(const vjm::Manipulator& manipulator,
                             const std::vector<Parameter>& parameters,
                             const Eigen::VectorXd& values);

/// Derivatives of the loaded platform pose at an equilibrium with respect to the coordinates of the
/// parameters: [translation m; rotation increment rad], base axes, a column each. Exact (implicit
/// differentiation of the equations of equilibrium).
Eigen::Matrix<double, 6, Eigen::Dynamic> pose_derivatives(const vjm::Manipulator& manipulator,
                                                          const vjm::Posture& posture,
                                                          const vjm::Load& load,
                                                          const vjm::Equilibrium& equilibrium,
                                                          const std::vector<Parameter>& parameters);

}  // namespace kinetostat::calibration
