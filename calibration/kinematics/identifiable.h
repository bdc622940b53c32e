// Which columns of a Jacobian readings determine, in a stated order of preference, and how well.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kinetostat::calibration {

/// A column that is left out of a fit.
struct LeftOutColumn {
  Eigen::Index column = 0;
  /// Kept columns that make up most of it; empty: no reading depends on it (to speak of).
  std::vector<Eigen::Index> like;
  bool like_nuisance = false;  // nuisance columns take part in making it up
};

struct IndependentColumns {
  std::vector<Eigen::Index> kept;  // ascending
  std::vector<LeftOutColumn> left_out;
};

/// Greedy choice of independent columns: the nuisance columns first, then column by column in their
/// order. With P the projector on what is there before, column c is kept where
///
///   |c - P c| > max(visible, alike |c|)
///
/// `columns`: derivatives of the readings in units of the noise, by changes of one tolerance each,
/// so that tolerance / |c - P c| is the standard deviation of an unknown, given those before it.
/// Ordered by preference instead of by pivots (Meggiolaro and Dubowsky, IEEE Int. Conf. Robotics
/// and Automation 2000, keep those that mean something), so that what is left out does not depend
/// on rounding.
IndependentColumns independent_columns(const Eigen::MatrixXd& nuisance,
                                       const Eigen::MatrixXd& columns, double visible,
                                       double alike);

/// Leaves out, of columns that are independent, those before `fixed` whose unknown is known no
/// better than to its tolerance beside all others: with the columns C, nuisance columns projected
/// out,
///
///   covariance = ratio^2 (C'C + ratio^2 diag(information))^-1,   left out while its variance > 1
///
/// one at a time, the last in order first. `information`: prior precision, in units of tolerances.
IndependentColumns determined_columns(const Eigen::MatrixXd& nuisance,
                                      const Eigen::MatrixXd& columns,
                                      const Eigen::VectorXd& information, double ratio,
                                      Eigen::Index fixed);

/// How well poses determine unknowns, from the singular values s_1 >= ... >= s_p > 0 of their m
/// whitened equations, columns scaled by tolerances, nuisance columns projected out. Larger is
/// better. All in units of 1, for the noise as stated (Sun and Hollerbach, IEEE Int. Conf. Robotics
/// and Automation 2008, compare them).
struct ObservabilityIndices {
  Eigen::Index equations = 0, unknowns = 0;
  double o1 = 0;  // (s_1 ... s_p)^(1/p) / sqrt(m): Borm and Menq 1991; D-optimality
  double o2 = 0;  // s_p / s_1: Driels and Pathre 1990; one over the condition number
  double o3 = 0;  // s_p: Nahvi, Hollerbach and Hayward 1994; E-optimality
  double o4 = 0;  // s_p^2 / s_1: Nahvi and Hollerbach 1996, noise amplification
  double o5 = 0;  // p / (1/s_1 + ... + 1/s_p) as Sun and Hollerbach 2008, for A-optimality

  double condition() const { return 1 / o2; }
};

/// Requires columns that are independent of each other and of the nuisance columns.
ObservabilityIndices observability_of(const Eigen::MatrixXd& nuisance,
                                      const Eigen::MatrixXd& columns);

}  // namespace kinetostat::calibration
