// Tests of whether a model is adequate. Every one compares the residual with a noise that does not
// come from the residual.
#pragma once

#include <Eigen/Core>

namespace kinetostat::calibration {

/// For one question; several tests of it share the level (Bonferroni).
inline constexpr double significance_level = 0.05;
/// Level of a rejection beyond doubt.
inline constexpr double certain_level = 0.001;

/// Chance that a sum of squares of normal deviates, or a quotient of two mean ones, is larger.
double chance_of_larger_chi_square(double statistic, double degrees_of_freedom);
double chance_of_larger_f(double f, double degrees_of_freedom, double degrees_of_freedom_below);

/// Sum of squares over the stated noise.
struct ChiSquareTest {
  double statistic = 0;
  Eigen::Index degrees_of_freedom = 0;
  double level = significance_level;
  double critical = 0;       // this share of sound models exceeds it
  double p_value = 1;        // share of sound models with a larger statistic
  double lower_p_value = 1;  // with a smaller one

  double reduced() const { return statistic / static_cast<double>(degrees_of_freedom); }
};

/// Requires degrees_of_freedom > 0.
ChiSquareTest chi_square_test(double statistic, Eigen::Index degrees_of_freedom,
                              double level = significance_level);

/// Misfit of the group means against the scatter within groups (Fisher's lack-of-fit test).
struct LackOfFitTest {
  double f = 0;
  Eigen::Index degrees_of_freedom_lack = 0;  // groups minus estimated unknowns
  Eigen::Index degrees_of_freedom_pure = 0;  // values minus groups
  double level = significance_level;
  double critical = 0;
  double p_value = 1;
};

/// F test of the two sums of squares, in the same whitening. Requires both degrees of freedom > 0
/// and a pure error > 0.
LackOfFitTest lack_of_fit_test(double lack, Eigen::Index degrees_of_freedom_lack, double pure,
                               Eigen::Index degrees_of_freedom_pure,
                               double level = significance_level);

/// The chi-square test over a noise that was estimated with `degrees_of_freedom_noise` (0: stated)
/// from the scatter of replicates among the same values: its p values are those of the lack of fit
/// of what is left of the statistic.
ChiSquareTest misfit_test(double statistic, Eigen::Index degrees_of_freedom,
                          Eigen::Index degrees_of_freedom_noise);

}  // namespace kinetostat::calibration
