// A campaign near its best fit, as linear algebra: the residual of the readings, and the part of a
// signature that is not confounded with the fitted parameters.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::calibration {

/// Residual space of a fit: r_N = N r with the projector N = I - Q Q', where the columns of Q are
/// orthonormal and span those of the whitened Jacobian J. Under noise alone r_N is standard normal
/// in that space, of dimension n - rank(J).
class ResidualSpace {
 public:
  /// `residual`: r, measured minus predicted in units of the noise, at the best fit. `fitted`: J,
  /// derivatives of the predictions in units of the noise, one column each; their rank may be
  /// anything.
  ResidualSpace(const Eigen::VectorXd& residual, const Eigen::MatrixXd& fitted);

  /// N C for whitened columns C: the part that is not confounded with the fitted parameters.
  Eigen::MatrixXd left_of(Eigen::MatrixXd columns) const;
  /// The same of many matrices, some at once: `use` is given the number, the columns and what is
  /// left of them, one after the other.
  void for_each_left(std::size_t count, const std::function<Eigen::MatrixXd(std::size_t)>& columns,
                     const std::function<void(std::size_t, const Eigen::MatrixXd& columns,
                                              const Eigen::MatrixXd& left)>& use) const;
  const Eigen::VectorXd& residual() const { return residual_; }
  Eigen::Index dimension() const { return residual_.size() - basis_.cols(); }
  /// Q: orthonormal columns that span what the fit can produce.
  const Eigen::MatrixXd& basis() const { return basis_; }

 private:
  // C - Q Q' C in the place of C, once, and as often as rounding asks for.
  void take_away_fitted(Eigen::Ref<Eigen::MatrixXd> columns) const;
  void reduce(Eigen::Ref<Eigen::MatrixXd> columns) const;

  Eigen::MatrixXd basis_;
  Eigen::VectorXd residual_;
};

/// The columns of a, then those of b.
Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Orthonormal columns that span the given ones; directions shorter than `smallest` after columns
/// have been taken away from one another are dropped (columns are in standard deviations of noise).
Eigen::MatrixXd span_of(const Eigen::MatrixXd& columns, double smallest = 0);

/// Length [standard deviations of the noise] below which a signature counts as absent.
inline constexpr double least_visible = 0.1;

/// The signature S of a candidate of one shape and size in the readings. First column: s = (y(usual
/// size) - y(0)) / sigma, the change of all predictions y in units of their noise sigma. Further
/// columns: derivatives of s with respect to further values, by one prior standard deviation each.
struct Signature {
  Eigen::MatrixXd columns;
  /// Factor by which each column was lengthened, to be visible in the readings; empty: 1.
  Eigen::RowVectorXd growth = {};
  /// Logarithm of how many it was chosen from as the one that explains most: taken off its
  /// significance (Bonferroni).
  double handicap = 0;

  Eigen::MatrixXd of_usual_size() const {
    return growth.size() == 0 ? columns : columns * growth.cwiseInverse().asDiagonal();
  }
};

/// Score test of one signature: is any of it in the residual?
struct Score {
  double detectability = 0;    // d' = |N s|, in standard deviations
  Eigen::Index dimension = 0;  // of the space that it spans there; 0: nothing can be seen
  double explained = 0;        // sum of squares of the residual in that space
  double handicap = 0;         // of its signature
};

/// Signatures prepared for many residuals: orthonormal columns U_i that span N S_i, in single
/// precision: with many readings they are most of the memory of a diagnosis.
class Screen {
 public:
  Screen(const ResidualSpace& space, const std::vector<Signature>& signatures);
  /// Of signatures that are seen otherwise, with the residual and the fit: none is copied.
  Screen(const ResidualSpace& space, const std::vector<Signature>& signatures,
         const std::function<Eigen::MatrixXd(const Eigen::MatrixXd& columns)>& seen);

  std::size_t size() const { return detectability_.size(); }
  double detectability(std::size_t i) const { return detectability_[i]; }
  /// Orthonormal columns; none where nothing can be seen.
  Eigen::MatrixXf::ConstColsBlockXpr span(std::size_t i) const {
    return basis_.middleCols(first_[i], size_of(i));
  }
  Eigen::Index dimension() const { return dimension_; }  // of the residual
  Score score(std::size_t i, const Eigen::VectorXd& residual) const;
  /// Significance -ln p of a score, p = P(F(k, m) > f), for a residual in the space:
  ///
  ///   f = (explained / k) / max(1, (|r_N|^2 - explained) / m),   m = dimension() - k,
  ///   explained = |U_i' r_N|^2,   k = columns of U_i
  ///
  /// The noise is estimated from the rest where the rest is larger than the stated noise.
  double significance(const Score& score, const Eigen::VectorXd& residual) const;
  /// The largest significance and whose it is, of the residual by which signatures were chosen that
  /// have a handicap.
  std::pair<double, std::size_t> largest_of_chosen(const Eigen::VectorXd& residual) const;
  /// The same of every column of residuals that have chosen nothing: without handicaps.
  std::vector<std::pair<double, std::size_t>> largest_significance(
      const Eigen::MatrixXd& residuals) const;
  /// Largest cosine between two spans, the largest singular value of U_i' U_j: 1 when some
  /// direction of the one is one of the other (aliased). 0 for empty spans.
  double confusion(std::size_t i, std::size_t j) const;

 private:
  Eigen::Index size_of(std::size_t i) const { return first_[i + 1] - first_[i]; }
  std::pair<double, std::size_t> most_significant(const Eigen::VectorXf& along, double total) const;
  double significance(const Score& score, double total) const;

  Eigen::Index dimension_;
  Eigen::MatrixXf basis_;            // all spans side by side
  std::vector<Eigen::Index> first_;  // column of each, and where the last one ends
  std::vector<double> detectability_, handicap_;
};

}  // namespace kinetostat::calibration
