#include "kinetostat/vjm/statics/stability.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/QR>

#include "kinetostat/spatial/decomposition.h"

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Below this share of the largest eigenvalue the rounding of the largest may be felt.
constexpr double safe_share = 1e-6;
// Terms of an eigenvalue cancel to no better than the equilibrium is known.
constexpr double cancellation = 1e-10;
// Components of a soft motion along stiff springs are rounding, which the energy squares.
constexpr double squared_rounding = 1e-26;

struct Level {
  VectorXd values;
  MatrixXd motions;
};

// Rayleigh and Ritz in the motions of a basis.
Level level_of(const MatrixXd& hessian, const MatrixXd& basis) {
  const spatial::SymmetricEigen eigen =
      spatial::symmetric_eigen(EnergyHessian{hessian, basis}.reduced());
  return {eigen.values, basis * eigen.vectors};
}

MatrixXd orthonormal(const MatrixXd& columns) {
  return Eigen::HouseholderQR<MatrixXd>(columns).householderQ() *
         MatrixXd::Identity(columns.rows(), columns.cols());
}

// Eigenvalues far below the largest are sought again among their own motions, where no stiff spring
// is deformed, and so on, level by level.
void add_levels(const MatrixXd& hessian, MatrixXd basis, EnergySpectrum& spectrum) {
  Index known = 0;
  while (basis.cols() > 0) {
    const Level level = level_of(hessian, basis);
    const double safe = safe_share * level.values.cwiseAbs().maxCoeff();
    std::vector<Index> sure, rest;
    for (Index i = 0; i < level.values.size(); ++i)
      (std::abs(level.values[i]) >= safe ? sure : rest).push_back(i);
    const auto count = static_cast<Index>(sure.size());
    spectrum.values.segment(known, count) = level.values(sure);
    spectrum.motions.middleCols(known, count) = level.motions(Eigen::all, sure);
    known += count;
    basis =
        rest.empty() ? MatrixXd(hessian.rows(), 0) : orthonormal(level.motions(Eigen::all, rest));
  }
}

template <class Less>
std::vector<Index> sorted_indices(Index size, const Less& less) {
  std::vector<Index> order(static_cast<std::size_t>(size));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), less);
  return order;
}

void sort_ascending(EnergySpectrum& spectrum) {
  const std::vector<Index> order = sorted_indices(spectrum.values.size(), [&](Index a, Index b) {
    return spectrum.values[a] < spectrum.values[b];
  });
  spectrum.values = VectorXd(spectrum.values(order));
  spectrum.motions = MatrixXd(spectrum.motions(Eigen::all, order));
}

}  // namespace

MatrixXd EnergyHessian::reduced() const {
  const MatrixXd product = basis.transpose() * hessian * basis;
  return 0.5 * (product + product.transpose());
}

int EnergySpectrum::neutral() const {
  int count = 0;
  for (Index i = 0; i < values.size(); ++i) count += is_neutral(i);
  return count;
}

std::vector<Index> EnergySpectrum::by_size() const {
  const auto size = [this](Index i) {
    return resolution[i] > 0 ? std::abs(values[i]) / resolution[i] : 0.0;
  };
  return sorted_indices(values.size(), [&](Index a, Index b) { return size(a) < size(b); });
}

VectorXd EnergySpectrum::without_neutral(int neutral) const {
  std::vector<Index> order = by_size();
  order.erase(order.begin(), order.begin() + std::min<std::ptrdiff_t>(neutral, std::ssize(order)));
  std::sort(order.begin(), order.end());
  return values(order);
}

EnergySpectrum energy_spectrum(const EnergyHessian& energy) {
  const Index n = energy.basis.cols();
  EnergySpectrum spectrum{VectorXd(n), VectorXd(n), MatrixXd(energy.hessian.rows(), n)};
  if (n == 0) return spectrum;
  add_levels(energy.hessian, energy.basis, spectrum);
  sort_ascending(spectrum);
  const MatrixXd terms = energy.hessian.cwiseAbs(), sizes = spectrum.motions.cwiseAbs();
  for (Index i = 0; i < n; ++i)
    spectrum.resolution[i] =
        cancellation * sizes.col(i).dot(terms * sizes.col(i)) + squared_rounding * terms.maxCoeff();
  if (energy.rounding.size() > 0)
    spectrum.resolution += (sizes.transpose() * energy.rounding).cwiseAbs2();
  return spectrum;
}

Stability stability_of(const EnergySpectrum& spectrum) {
  Stability result{.neutral = spectrum.neutral(),
                   .margin = std::numeric_limits<double>::infinity()};
  for (Index i = 0; i < spectrum.values.size(); ++i) {
    if (spectrum.is_neutral(i)) continue;
    result.unstable += spectrum.values[i] < 0;
    result.margin = std::min(result.margin, spectrum.values[i]);
  }
  return result;
}

Stability combined(const Stability& a, const Stability& b) {
  return {a.unstable + b.unstable, a.neutral + b.neutral, std::min(a.margin, b.margin)};
}

}  // namespace kinetostat::vjm
