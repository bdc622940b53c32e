// What many columns together do not explain of some values, however large a few of them are.
#pragma once

#include <Eigen/Core>

namespace kinetostat::calibration {

/// Residual y - B b - E e of the robust ridge regression
///
///   min over b, e of  sum_i rho(y_i - (B b + E e)_i) + |e|^2 / 2,
///   rho(r) = r^2 / 2 up to |r| = bend, bend |r| - bend^2 / 2 beyond
///
/// by `rounds` of iteratively reweighted least squares from weights of one (Huber, Ann. Math. Stat.
/// 35, 1964). y: n values in units of their noise; B = `free`: n x p, of any rank; E = `usual`:
/// n x q columns whose coefficients are usually about one. Solved in p + q unknowns or, where they
/// are more than the values, in n: the cost grows with n (p + q) min(n, p + q).
Eigen::VectorXd robust_residual(const Eigen::VectorXd& y, const Eigen::MatrixXd& free,
                                const Eigen::MatrixXd& usual, double bend, int rounds);

}  // namespace kinetostat::calibration
