// Values that some columns do not explain, nor all other values predict.
#pragma once

#include <Eigen/Core>

namespace kinetostat::calibration {

struct RobustResidual {
  Eigen::VectorXd left;  // y - B b - E e
  /// What each value is off the prediction from all others, over the standard deviation of that: a
  /// column that one value alone determines says nothing for it.
  Eigen::VectorXd surprise;
};

/// Robust ridge regression
///
///   min over b, e of  sum_i rho(left_i) + |e|^2 / 2,   left = y - B b - E e
///   rho(r) = r^2 / 2 up to |r| = bend, bend |r| - bend^2 / 2 beyond
///
/// by `rounds` of iteratively reweighted least squares from weights of one (Huber, Ann. Math. Stat.
/// 35, 1964). y: n values in units of their noise; B = `free`: n x p, of any rank; E = `usual`:
/// n x q columns whose coefficients are usually about one. With X = [B E], the last weights W and
/// the ridge R of E (next to none for B)
///
///   s_i = x_i' (X' W X + R)^-1 x_i,   h_i = w_i s_i
///   surprise_i = left_i / (1 - h_i) / sqrt(1 + s_i / (1 - h_i))
///
/// is the leave-one-out residual, standardised (Cook and Weisberg, Residuals and Influence in
/// Regression, 1982).
RobustResidual robust_residual(const Eigen::VectorXd& y, const Eigen::MatrixXd& free,
                               const Eigen::MatrixXd& usual, double bend, int rounds);

}  // namespace kinetostat::calibration
