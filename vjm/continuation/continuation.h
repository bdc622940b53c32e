// Steps along a path of equilibria. Internal to this module: path.h is what others use.
#pragma once

#include <optional>

#include "kinetostat/vjm/continuation/path_equations.h"

namespace kinetostat::vjm {

/// An equilibrium on a path, the direction in which the path goes on (unit length), and what
/// decides its stability.
struct Station {
  PathState at;
  Eigen::VectorXd tangent;
  EnergySpectrum spectrum;  // on the motions that the task allows

  double parameter_rate() const { return tangent[tangent.size() - 1]; }
};

class Continuation {
 public:
  explicit Continuation(const PathEquations& equations) : equations_(equations) {}

  /// The equilibrium nearest to from + guess with normal . change = offset (Keller's bordered
  /// system, Newton's method with the exact derivative), going on along `forward`.
  std::optional<Station> correct(const PathState& from, const Eigen::VectorXd& guess,
                                 const Eigen::VectorXd& normal, double offset,
                                 const Eigen::VectorXd& forward);
  /// The first station: the parameter grows or, where it cannot, the force that pushes the
  /// platform. Nothing when the path does not leave the point.
  std::optional<Station> first(const PathState& at);
  /// A step of that length; nothing when it is too long for the curvature of the path.
  std::optional<Station> step(const Station& from, double length);
  /// Between two stations of a path, at the share 0..1 of the step.
  std::optional<Station> between(const Station& from, const Station& to, double share);
  /// Between two stations that have the parameter between them, ends included.
  std::optional<Station> at_parameter(const Station& from, const Station& to, double parameter);

  Eigen::VectorXd difference(const Station& from, const Station& to) const {
    return equations_.difference(from.at, to.at);
  }
  /// n x (n + 1), as PathEquations has it.
  Eigen::MatrixXd derivative(const Station& station) const;
  const PathEquations& equations() const { return equations_; }

  int iterations() const { return iterations_; }  // of the last correction

 private:
  /// Nothing where the path has no direction.
  std::optional<Station> station(const PathState& at, const Eigen::VectorXd& forward);
  /// Where `between` finds the parameter, by halving.
  std::optional<Station> halved_to(const Station& from, const Station& to, double parameter);

  const PathEquations& equations_;
  int iterations_ = 0;
};

}  // namespace kinetostat::vjm
