#include "kinetostat/calibration/statistics/residual_space.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kinetostat/calibration/statistics/goodness_of_fit.h"
#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/spatial/products.h"

namespace kinetostat::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd beside(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

MatrixXd span_of(const MatrixXd& columns, double smallest) {
  MatrixXd scaled = columns;
  double longest = 0;
  for (Index j = 0; j < columns.cols(); ++j) longest = std::max(longest, columns.col(j).norm());
  if (longest <= smallest) return MatrixXd(columns.rows(), 0);
  Index kept = 0;
  for (Index j = 0; j < columns.cols(); ++j)
    if (const double length = columns.col(j).norm(); length > std::max(smallest, 1e-12 * longest))
      scaled.col(kept++) = columns.col(j) / length;
  return spatial::range_of(scaled.leftCols(kept), 1e-9);
}

ResidualSpace::ResidualSpace(const VectorXd& residual, const MatrixXd& fitted)
    : basis_(span_of(fitted)) {
  residual_ = left_of(residual);
}

void ResidualSpace::take_away_fitted(Eigen::Ref<MatrixXd> columns) const {
  constexpr Index few = 2;  // that products of matrices gain nothing from
  if (columns.cols() <= few)
    columns -= basis_ * (basis_.transpose() * columns);
  else
    spatial::add_product(basis_, -spatial::transposed_product(basis_, columns), columns);
}

void ResidualSpace::reduce(Eigen::Ref<MatrixXd> columns) const {
  // Of what loses most of its length, once more against rounding: Kahan's "twice is enough".
  constexpr double most = 1e-4;  // of the square
  const Eigen::RowVectorXd before = columns.colwise().squaredNorm();
  take_away_fitted(columns);
  for (Index j = 0; j < columns.cols(); ++j)
    if (!(columns.col(j).squaredNorm() > most * before[j])) take_away_fitted(columns.col(j));
}

MatrixXd ResidualSpace::left_of(MatrixXd columns) const {
  reduce(columns);
  return columns;
}

void ResidualSpace::for_each_left(
    std::size_t count, const std::function<MatrixXd(std::size_t)>& columns,
    const std::function<void(std::size_t, const MatrixXd&, const MatrixXd&)>& use) const {
  constexpr Index enough = 24;  // for products of matrices
  std::vector<MatrixXd> taken;
  MatrixXd left;  // room for the largest group
  Index total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    total += taken.emplace_back(columns(i)).cols();
    if (total < enough && i + 1 < count) continue;
    if (left.cols() < total) left.resize(residual_.size(), total);
    for (Index at = 0; const MatrixXd& own : taken) {
      left.middleCols(at, own.cols()) = own;
      at += own.cols();
    }
    reduce(left.leftCols(total));
    std::size_t number = i + 1 - taken.size();
    for (Index at = 0; const MatrixXd& own : taken) {
      use(number++, own, left.middleCols(at, own.cols()));
      at += own.cols();
    }
    taken.clear();
    total = 0;
  }
}

Screen::Screen(const ResidualSpace& space, const std::vector<Signature>& signatures)
    : Screen(space, signatures, [](const MatrixXd& columns) { return columns; }) {}

Screen::Screen(const ResidualSpace& space, const std::vector<Signature>& signatures,
               const std::function<MatrixXd(const MatrixXd& columns)>& seen)
    : dimension_(space.dimension()) {
  Index columns = 0;
  for (const Signature& signature : signatures) columns += signature.columns.cols();
  basis_.resize(space.residual().size(), columns);
  first_.push_back(0);
  space.for_each_left(
      signatures.size(), [&](std::size_t i) { return seen(signatures[i].columns); },
      [&](std::size_t i, const MatrixXd& columns_seen, const MatrixXd& left) {
        handicap_.push_back(signatures[i].handicap);
        detectability_.push_back(left.cols() == 0 ? 0 : left.col(0).norm());
        // Rounding of the part that the fit produces is no signature either.
        const MatrixXd span = span_of(left, std::max(least_visible, 1e-7 * columns_seen.norm()));
        basis_.middleCols(first_.back(), span.cols()) = span.cast<float>();
        first_.push_back(first_.back() + span.cols());
      });
  basis_.conservativeResize(Eigen::NoChange, first_.back());
}

Score Screen::score(std::size_t i, const VectorXd& residual) const {
  return {.detectability = detectability_[i],
          .dimension = size_of(i),
          .explained = (span(i).transpose().cast<double>() * residual).squaredNorm(),
          .handicap = handicap_[i]};
}

double Screen::significance(const Score& score, const VectorXd& residual) const {
  return significance(score, residual.squaredNorm());
}

double Screen::significance(const Score& score, double total) const {
  const auto k = static_cast<double>(score.dimension);
  const auto rest = static_cast<double>(dimension_ - score.dimension);
  if (score.dimension == 0 || rest < 1) return 0;
  const double noise = std::max(1.0, (total - score.explained) / rest);
  const double f = score.explained / k / noise;
  if (!(f > 0)) return 0;
  return std::max(0.0,
                  -std::log(std::max(chance_of_larger_f(f, k, rest), 1e-300)) - score.handicap);
}

std::vector<std::pair<double, std::size_t>> Screen::largest_significance(
    const MatrixXd& residuals) const {
  const Eigen::MatrixXf single = residuals.cast<float>();
  const Eigen::MatrixXf along = spatial::transposed_product(basis_, single);
  std::vector<std::pair<double, std::size_t>> largest;
  for (Index column = 0; column < residuals.cols(); ++column)
    largest.push_back(most_significant(along.col(column), residuals.col(column).squaredNorm()));
  return largest;
}

// Among spans of one dimension the one that explains most is the most significant.
std::pair<double, std::size_t> Screen::most_significant(const Eigen::VectorXf& along,
                                                        double total) const {
  std::map<Index, std::pair<double, std::size_t>> explaining;  // of each dimension the most
  for (std::size_t i = 0; i < size(); ++i) {
    const double explained = along.segment(first_[i], size_of(i)).squaredNorm();
    auto& most = explaining[size_of(i)];
    if (explained > most.first) most = {explained, i};
  }
  std::pair<double, std::size_t> largest{0, 0};
  for (const auto& [dimension, most] : explaining) {
    const double significance =
        this->significance(Score{.dimension = dimension, .explained = most.first}, total);
    if (significance > largest.first) largest = {significance, most.second};
  }
  return largest;
}

std::pair<double, std::size_t> Screen::largest_of_chosen(const VectorXd& residual) const {
  std::pair<double, std::size_t> largest{0, 0};
  for (std::size_t i = 0; i < size(); ++i)
    if (const double own = significance(score(i, residual), residual); own > largest.first)
      largest = {own, i};
  return largest;
}

double Screen::confusion(std::size_t i, std::size_t j) const {
  if (size_of(i) == 0 || size_of(j) == 0) return 0;
  const MatrixXd cosines = (span(i).transpose() * span(j)).cast<double>();
  return std::min(1.0, spatial::singular_value_decomposition(cosines).values[0]);
}

}  // namespace kinetostat::calibration
