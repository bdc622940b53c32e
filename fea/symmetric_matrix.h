// A large sparse symmetric matrix.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::fea {

/// Columns on end, each with its diagonal entry first and the rows below it ascending.
struct SymmetricMatrix {
  std::vector<int> column_start = {0};  // size() + 1 of them
  std::vector<int> row = {};
  std::vector<double> value = {};

  Eigen::Index size() const { return static_cast<Eigen::Index>(column_start.size()) - 1; }
  std::size_t entries() const { return row.size(); }

  /// B - A X for several columns at once, summed in extended precision: where A X nearly cancels B,
  /// the digits that are left are right.
  Eigen::MatrixXd residual(const Eigen::MatrixXd& b, const Eigen::MatrixXd& x) const;
};

/// Which blocks of three unknowns are linked: for each, the numbers of itself and of its later
/// partners, ascending.
struct BlockPattern {
  std::vector<int> start = {0};
  std::vector<int> partner = {};

  int blocks() const { return static_cast<int>(start.size()) - 1; }
};

}  // namespace kinetostat::fea
