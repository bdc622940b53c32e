// A campaign near its best fit, as linear algebra: what is left of the readings, and how much of
// the mark of something missing the fitted parameters cannot absorb.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::calibration {

/// Whitened values that are left once everything that is fitted anyway has been fitted: residuals
/// are projected on the complement of what the fit can produce. Under noise alone they are standard
/// normal there.
class ResidualSpace {
 public:
  /// `residual`: measured minus predicted over noise, at the best fit. `fitted`: derivatives of the
  /// predictions over noise, one column each; their rank may be anything.
  ResidualSpace(const Eigen::VectorXd& residual, const Eigen::MatrixXd& fitted);

  /// What of whitened columns the fit cannot absorb.
  Eigen::MatrixXd left_of(const Eigen::MatrixXd& columns) const;
  const Eigen::VectorXd& residual() const { return residual_; }
  Eigen::Index dimension() const { return residual_.size() - basis_.cols(); }
  /// Orthonormal columns that span what the fit can produce.
  const Eigen::MatrixXd& basis() const { return basis_; }

 private:
  Eigen::MatrixXd basis_;
  Eigen::VectorXd residual_;
};

/// Orthonormal columns that span the given ones; directions shorter than `smallest` after columns
/// have been taken away from one another are dropped (columns are in standard deviations of noise).
Eigen::MatrixXd span_of(const Eigen::MatrixXd& columns, double smallest = 0);

/// Length [standard deviations] below which a mark is not there, for any purpose.
inline constexpr double least_visible = 0.1;

/// The mark of a candidate of one shape and size in the readings: the change of all predictions
/// over their noise when it is present with its usual size, first; then, when it has further
/// values, their derivatives by one prior standard deviation each.
struct Signature {
  Eigen::MatrixXd columns;
  /// By how much each column was lengthened, to be seen in the readings; empty: not at all.
  Eigen::RowVectorXd growth = {};

  Eigen::MatrixXd of_usual_size() const {
    return growth.size() == 0 ? columns : columns * growth.cwiseInverse().asDiagonal();
  }
};

/// A score test of one signature: is any of it in the residual?
struct Score {
  double detectability = 0;    // d': length of the mark that the fit cannot absorb
  Eigen::Index dimension = 0;  // of the space that it spans there; 0: nothing can be seen
  double explained = 0;        // sum of squares of the residual in that space
};

/// Signatures prepared for many residuals: their spans beside what the fit absorbs.
class Screen {
 public:
  Screen(const ResidualSpace& space, const std::vector<Signature>& signatures);

  std::size_t size() const { return spans_.size(); }
  double detectability(std::size_t i) const { return detectability_[i]; }
  /// Orthonormal columns; none where nothing can be seen.
  const Eigen::MatrixXd& span(std::size_t i) const { return spans_[i]; }
  Eigen::Index dimension() const { return dimension_; }  // of the residual
  Score score(std::size_t i, const Eigen::VectorXd& residual) const;
  /// Significance of a score, minus its natural logarithm: how unlikely that much is explained by
  /// noise, the noise taken to be what is left over when that is more than what it is said to be.
  double surprise(const Score& score, const Eigen::VectorXd& residual) const;
  /// Largest cosine between a direction of one span and one of another: 1 when something that the
  /// one does, the other can do too. 0 for spans of nothing.
  double confusion(std::size_t i, std::size_t j) const;

 private:
  Eigen::Index dimension_;
  std::vector<Eigen::MatrixXd> spans_;
  std::vector<double> detectability_;
};

}  // namespace kinetostat::calibration
