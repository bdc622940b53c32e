// Two effects may hide one another: neither of them shows alone, both together do.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "kinetostat/calibration/statistics/residual_space.h"

namespace kinetostat::calibration {

/// What explains so much of the square of a residual promises: twice its log evidence, to first
/// order, with so many columns that act on so many values (Schwarz, Ann. Stat. 6, 1978).
double promise(double explained, Eigen::Index columns, Eigen::Index values);

/// All pairs of some signatures, prepared for many residuals: the score test of a pair uses both
/// spans together.
class PairScreen {
 public:
  /// `members`: which signatures of the screen take part, each with all others.
  PairScreen(const Screen& screen, const std::vector<std::size_t>& members);

  /// How unlikely noise alone explains as much as the most significant pair does together: a
  /// standard normal deviate (Wilson and Hilferty 1931), the noise as in Screen::significance().
  /// The second number is the pair's, in the order of pairs(). One entry a column of residuals.
  std::vector<std::pair<double, std::size_t>> largest_significance(
      const Eigen::MatrixXd& residuals) const;
  /// The same of all pairs, for one residual.
  Eigen::VectorXd significances(const Eigen::VectorXd& residual) const;
  /// How much of the square of a residual each pair explains together, and with how many columns.
  std::vector<std::pair<double, Eigen::Index>> explained(const Eigen::VectorXd& residual) const;

  /// Pairs of signatures that are distinguishable at all.
  const std::vector<std::pair<std::size_t, std::size_t>>& pairs() const { return pairs_; }

 private:
  struct Member {
    Eigen::Index at = 0, size = 0;  // columns of the basis
  };
  // The second span beside the first: what of it is new, as unit directions.
  struct Addition {
    std::size_t first = 0, second = 0;  // members
    Eigen::MatrixXd of_first, of_second;
  };

  Eigen::VectorXd significances(const Eigen::VectorXd& along, double total) const;
  std::pair<double, Eigen::Index> explained(const Addition& pair,
                                            const Eigen::VectorXd& along) const;

  Eigen::Index dimension_;
  Eigen::MatrixXd basis_;  // all spans side by side
  std::vector<Member> members_;
  std::vector<Addition> additions_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
};

}  // namespace kinetostat::calibration
