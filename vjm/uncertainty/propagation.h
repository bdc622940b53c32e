// Uncertainties of the inputs of a robot, carried to whatever is computed of it (GUM 5).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/vjm/io/robot_file.h"

namespace kinetostat::vjm {

/// What is computed of a robot: always as many numbers. None where there is no equilibrium. It is
/// called for other robots at a time from several threads.
using Computation = std::function<std::optional<Eigen::VectorXd>(const Robot&)>;

/// k of all expanded uncertainties: about 95 % of what is possible lies within.
inline constexpr double coverage_factor = 2;

/// To first order in the sources.
struct Propagation {
  std::vector<UncertaintySource> sources;
  Eigen::VectorXd value;     // of the robot as its file has it
  Eigen::VectorXd estimate;  // with every source at its estimate
  /// Derivative of each number by each source, times the standard uncertainty of the source.
  Eigen::MatrixXd parts;
  Eigen::MatrixXd correlation;  // of the sources

  /// Combined standard uncertainty of a number, u^2 = p' R p with p its parts (GUM eq. 13). NaN for
  /// one that is not finite.
  double deviation(Eigen::Index number) const;
  /// Above the rounding of the differences.
  bool is_uncertain(Eigen::Index number) const;
  double expanded(Eigen::Index number) const { return coverage_factor * deviation(number); }
  /// Of u^2, p_i (R p)_i / u^2: they add up to 1. Negative where a source makes up for another one
  /// that it is correlated with. All 0 for a number that is certain.
  Eigen::VectorXd shares(Eigen::Index number) const;
  /// Their mean over the numbers from `first` on that are uncertain and finite.
  Eigen::VectorXd mean_shares(Eigen::Index first, Eigen::Index count) const;
  /// Covariance of all numbers.
  Eigen::MatrixXd covariance() const;
};

/// Differences of the whole computation over 3e-4 standard uncertainties to either side: their
/// error is that of the third derivative, 1e-8 for a compliance whose spring is known to 30 %. A
/// source beyond whose estimate nothing is possible is moved to one side. Throws
/// common::NoConvergence, naming the source, where nothing can be computed.
Propagation propagate(const Robot& robot, const Computation& compute, int threads,
                      common::Progress& progress);

}  // namespace kinetostat::vjm
