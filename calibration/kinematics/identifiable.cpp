#include "kinetostat/calibration/kinematics/identifiable.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/calibration/statistics/residual_space.h"
#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Orthonormal columns, to which further ones are added.
class Basis {
 public:
  Basis(Index rows, Index most) : q_(rows, most) {}

  VectorXd left_of(VectorXd column) const {
    const auto known = q_.leftCols(count_);
    for (int twice = 0; twice < 2; ++twice) column -= known * (known.transpose() * column);
    return column;
  }
  void add(const VectorXd& left) { q_.col(count_++) = left.normalized(); }

 private:
  MatrixXd q_;
  Index count_ = 0;
};

// What makes up a column: members whose share of it is at least this part of the largest share.
constexpr double takes_part = 0.3;

LeftOutColumn left_out(Index column, const VectorXd& values, const MatrixXd& nuisance,
                       const MatrixXd& columns, const std::vector<Index>& kept) {
  LeftOutColumn result{.column = column, .like = {}};
  const MatrixXd all = beside(nuisance, columns(Eigen::all, kept));
  if (all.cols() == 0) return result;
  const VectorXd lengths = all.colwise().norm().cwiseMax(1e-300);
  const MatrixXd scaled = all * lengths.cwiseInverse().asDiagonal();
  const VectorXd shares =
      spatial::shortest_least_squares_solution(scaled, values, 1e-9).col(0).cwiseAbs();
  const double least = takes_part * shares.maxCoeff();
  for (Index k = 0; k < shares.size(); ++k) {
    if (shares[k] < least) continue;
    if (k < nuisance.cols())
      result.like_nuisance = true;
    else
      result.like.push_back(kept[static_cast<std::size_t>(k - nuisance.cols())]);
  }
  return result;
}

// The part of columns that nuisance columns do not make up.
MatrixXd without(const MatrixXd& nuisance, MatrixXd columns) {
  if (const MatrixXd known = span_of(nuisance); known.cols() > 0)
    for (int twice = 0; twice < 2; ++twice) columns -= known * (known.transpose() * columns);
  return columns;
}

}  // namespace

IndependentColumns independent_columns(const MatrixXd& nuisance, const MatrixXd& columns,
                                       double visible, double alike) {
  constexpr double rounding = 1e-9;
  Basis basis(columns.rows(), std::min(columns.rows(), nuisance.cols() + columns.cols()) + 1);
  for (Index k = 0; k < nuisance.cols(); ++k)
    if (const VectorXd left = basis.left_of(nuisance.col(k));
        left.norm() > rounding * nuisance.col(k).norm())
      basis.add(left);
  const double largest = columns.cols() == 0 ? 0 : columns.colwise().norm().maxCoeff();
  IndependentColumns result;
  for (Index k = 0; k < columns.cols(); ++k) {
    const VectorXd column = columns.col(k), left = basis.left_of(column);
    const double length = column.norm();
    if (left.norm() > std::max({visible, alike * length, rounding * largest})) {
      basis.add(left);
      result.kept.push_back(k);
    } else if (length > std::max(visible, rounding * largest)) {
      result.left_out.push_back(calibration::left_out(k, column, nuisance, columns, result.kept));
    } else {
      result.left_out.push_back({.column = k, .like = {}});
    }
  }
  return result;
}

IndependentColumns determined_columns(const MatrixXd& nuisance, const MatrixXd& columns,
                                      const VectorXd& information, double ratio, Index fixed) {
  const MatrixXd left = without(nuisance, columns);
  IndependentColumns result;
  for (Index k = 0; k < columns.cols(); ++k) result.kept.push_back(k);
  std::vector<Index> dropped;
  for (;;) {
    const std::vector<Index>& kept = result.kept;
    MatrixXd normal = left(Eigen::all, kept).transpose() * left(Eigen::all, kept);
    normal.diagonal() += ratio * ratio * information(kept);
    const VectorXd variance =
        ratio * ratio *
        spatial::solve_symmetric(normal, MatrixXd::Identity(normal.rows(), normal.cols()))
            .diagonal();
    Index worst = std::ssize(kept) - 1;
    while (worst >= 0 && (kept[static_cast<std::size_t>(worst)] >= fixed || variance[worst] <= 1))
      --worst;
    if (worst < 0) break;
    dropped.push_back(kept[static_cast<std::size_t>(worst)]);
    result.kept.erase(result.kept.begin() + worst);
  }
  for (const Index k : dropped)
    result.left_out.push_back(
        calibration::left_out(k, columns.col(k), nuisance, columns, result.kept));
  return result;
}

ObservabilityIndices observability_of(const MatrixXd& nuisance, const MatrixXd& columns) {
  const MatrixXd left = without(nuisance, columns);
  const VectorXd s = spatial::singular_values(left);
  const auto p = static_cast<double>(s.size());
  const double least = s.minCoeff(), largest = s.maxCoeff();
  return {.equations = columns.rows(),
          .unknowns = s.size(),
          .o1 = std::exp(s.array().log().sum() / p) / std::sqrt(static_cast<double>(left.rows())),
          .o2 = least / largest,
          .o3 = least,
          .o4 = least * least / largest,
          .o5 = p / s.cwiseInverse().sum()};
}

}  // namespace kinetostat::calibration
