#include "kinetostat/calibration/search/pair_screen.h"

#include <cmath>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Squared sine below which one direction is the other: to be distinguished, both would have to be
// hundreds of times as long as the noise.
constexpr double same = 1e-4;

double normal_deviate(double chi_square, double k) {
  const double spread = 2 / (9 * k);
  return (std::cbrt(chi_square / k) - (1 - spread)) / std::sqrt(spread);
}

}  // namespace

double promise(double explained, Index columns, Index values) {
  return explained - std::log(static_cast<double>(values)) * static_cast<double>(columns);
}

PairScreen::PairScreen(const Screen& screen, const std::vector<std::size_t>& members)
    : dimension_(screen.dimension()) {
  Index columns = 0;
  for (const std::size_t m : members) {
    members_.push_back({columns, screen.span(m).cols()});
    columns += screen.span(m).cols();
  }
  basis_.resize(screen.span(0).rows(), columns);
  for (std::size_t m = 0; m < members.size(); ++m)
    basis_.middleCols(members_[m].at, members_[m].size) = screen.span(members[m]).cast<double>();
  const MatrixXd cosines = basis_.transpose() * basis_;
  for (std::size_t a = 0; a < members_.size(); ++a)
    for (std::size_t b = a + 1; b < members_.size(); ++b) {
      if (members_[a].size == 0 || members_[b].size == 0) continue;
      const MatrixXd between =
          cosines.block(members_[a].at, members_[b].at, members_[a].size, members_[b].size);
      const spatial::SymmetricEigen left = spatial::symmetric_eigen(
          MatrixXd::Identity(members_[b].size, members_[b].size) - between.transpose() * between);
      std::vector<Index> kept;
      for (Index i = 0; i < left.values.size(); ++i)
        if (left.values[i] > same) kept.push_back(i);
      if (kept.empty()) continue;
      const MatrixXd directions = left.vectors(Eigen::all, kept) *
                                  left.values(kept).cwiseSqrt().cwiseInverse().asDiagonal();
      additions_.push_back({a, b, -(between * directions).transpose(), directions.transpose()});
      pairs_.emplace_back(members[a], members[b]);
    }
}

VectorXd PairScreen::significances(const VectorXd& residual) const {
  return significances(basis_.transpose() * residual, residual.squaredNorm());
}

std::pair<double, Index> PairScreen::explained(const Addition& pair, const VectorXd& along) const {
  const Member &a = members_[pair.first], &b = members_[pair.second];
  const auto of_first = along.segment(a.at, a.size);
  return {
      of_first.squaredNorm() +
          (pair.of_first * of_first + pair.of_second * along.segment(b.at, b.size)).squaredNorm(),
      a.size + pair.of_second.rows()};
}

std::vector<std::pair<double, Index>> PairScreen::explained(const VectorXd& residual) const {
  const VectorXd along = basis_.transpose() * residual;
  std::vector<std::pair<double, Index>> result;
  for (const Addition& pair : additions_) result.push_back(explained(pair, along));
  return result;
}

VectorXd PairScreen::significances(const VectorXd& along, double total) const {
  VectorXd result = VectorXd::Zero(static_cast<Index>(additions_.size()));
  for (std::size_t p = 0; p < additions_.size(); ++p) {
    const auto [square, columns] = explained(additions_[p], along);
    const auto k = static_cast<double>(columns);
    const double rest = static_cast<double>(dimension_) - k;
    if (rest < 1) continue;
    const double noise = std::max(1.0, (total - square) / rest);
    result[static_cast<Index>(p)] = normal_deviate(square / noise, k);
  }
  return result;
}

std::vector<std::pair<double, std::size_t>> PairScreen::largest_significance(
    const MatrixXd& residuals) const {
  std::vector<std::pair<double, std::size_t>> largest(static_cast<std::size_t>(residuals.cols()),
                                                      {0, 0});
  if (additions_.empty()) return largest;
  const MatrixXd along = basis_.transpose() * residuals;
  for (Index column = 0; column < residuals.cols(); ++column) {
    Index where = 0;
    const double most =
        significances(along.col(column), residuals.col(column).squaredNorm()).maxCoeff(&where);
    largest[static_cast<std::size_t>(column)] = {most, static_cast<std::size_t>(where)};
  }
  return largest;
}

}  // namespace kinetostat::calibration
