// Nonlinear least squares within bounds: the one solver behind every fit of this module.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::calibration {

/// Residuals r(x), already divided by their noise, and their derivatives dr/dx (one row a residual,
/// one column an unknown).
struct Linearisation {
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
};

/// Empty where x has no residual; the solver then comes back with a shorter step.
using ResidualFunction = std::function<std::optional<Linearisation>(const Eigen::VectorXd& x)>;

/// Cost rho(r) of a residual of r standard deviations: r^2, or less, so that outliers count less.
/// The widths are those at which 95 % efficiency is left when the noise is normal after all
/// (Holland and Welsch 1977).
enum class Loss {
  squares,
  huber,  // r^2 up to 1.345, then a straight line: convex, one minimum
  cauchy  // c^2 log(1 + (r/c)^2) with c = 2.385: far outliers hardly count at all
};

/// Derivative of the cost with respect to r^2: 1 for squares, the weight of a residual otherwise.
double weight_of(Loss loss, double residual);
double cost_of(Loss loss, double residual);
/// Derivative of weight * residual with respect to the residual.
double influence_slope(Loss loss, double residual);

struct LeastSquaresOptions {
  int max_iterations = 200;
  /// Ends when a step changes the residuals by less than this share of their scale.
  double tolerance = 1e-13;
  /// Ends as well when the fifth step in a row promises to lower the cost by less than this.
  double least_gain = 0;
  /// Scale of the residuals beside which a change is small; 0: their norm at the start.
  double scale = 0;
  /// Bounds of the unknowns and of one step; empty: none. Infinite entries are allowed. The start
  /// must lie within the bounds. Steps become longer where the linear model holds that far.
  Eigen::VectorXd lower = {}, upper = {}, longest_step = {};
  Loss loss = Loss::squares;
  /// Damping of the first step, relative to the squared column lengths of the Jacobian. Small:
  /// trust the linear model.
  double first_damping = 1e-4;
};

enum class LeastSquaresStatus {
  converged,
  no_start,        // there is no residual at the start
  stalled,         // no step lowers the cost, yet the linear model promises that one would
  max_iterations,  // still moving
};

enum class BoundHit { none, lower, upper };

struct LeastSquaresResult {
  LeastSquaresStatus status = LeastSquaresStatus::converged;
  Eigen::VectorXd x;
  Linearisation at;           // there
  Eigen::VectorXd weights;    // of the residuals, 1 for squares
  std::vector<BoundHit> hit;  // one an unknown: the bound holds it back
  int iterations = 0;         // evaluations of the residuals, the first included
  double cost = 0;            // sum of cost_of

  /// Unknowns that no bound holds.
  std::vector<Eigen::Index> free() const;
};

/// Levenberg and Marquardt's method: damping by the column lengths of the Jacobian, controlled by
/// the ratio of achieved to promised decrease (Nielsen 1999); every step solves its linear least
/// squares problem within the bounds by orthogonal factors. Robust losses by reweighting.
/// Deterministic. Throws std::invalid_argument when sizes disagree or the start is out of bounds.
LeastSquaresResult minimise(const ResidualFunction& residuals, const Eigen::VectorXd& start,
                            const LeastSquaresOptions& options = {});

/// A itself, or of more than 8192 rows the triangle R with R'R = A'A: the same lengths of columns
/// and angles between them, and no room.
Eigen::MatrixXd condensed(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

/// Inverse of J'J over the free unknowns, zero in rows and columns of held ones; columns are scaled
/// first, so that units do not matter. Requires full rank.
Eigen::MatrixXd inverse_normal_matrix(const Eigen::MatrixXd& jacobian,
                                      const std::vector<Eigen::Index>& free);

/// A direction in which the unknowns are poorly known.
struct WeakCombination {
  /// Change of the unknowns along it, in their own units, that moves all residuals together by one
  /// standard deviation (|J direction| = 1).
  Eigen::VectorXd direction;
  /// How much of each unknown's length takes part, largest 1.
  Eigen::VectorXd participation;
  double condition_index = 0;  // largest over this singular value, columns of unit length
};

/// Right singular vectors of the Jacobian with columns of unit length, over the free unknowns,
/// whose condition index is at least `from` (Belsley, Kuh and Welsch 1980: 30 is strong
/// collinearity); weakest first. Infinite index and a unit direction where the rank is not full.
std::vector<WeakCombination> weak_combinations(const Eigen::MatrixXd& jacobian,
                                               const std::vector<Eigen::Index>& free,
                                               double from = 30);

}  // namespace kinetostat::calibration
