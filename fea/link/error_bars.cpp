#include "kinetostat/fea/link/error_bars.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace kinetostat::fea {
namespace {

using Eigen::MatrixXd;

// Mean over all load cases of a change of the flexibility, beside the flexibility itself: the same
// at every reference point and in all units.
double mean_change(const MatrixXd& change, const MatrixXd& flexibility) {
  return flexibility.llt().solve(change).trace() / static_cast<double>(flexibility.rows());
}

double power(const MeshOutcome& mesh, double rate) {
  return std::pow(static_cast<double>(mesh.unknowns), -rate);
}

// The rate r of c = c_exact - a n^-r through three meshes: the ratio of the two changes falls with
// r.
std::optional<double> rate_through(const MeshOutcome& a, const MeshOutcome& b,
                                   const MeshOutcome& c) {
  if (!(a.unknowns < b.unknowns && b.unknowns < c.unknowns)) return {};
  const double first = mean_change(b.flexibility - a.flexibility, c.flexibility);
  const double second = mean_change(c.flexibility - b.flexibility, c.flexibility);
  if (!(first > 0 && second > 0)) return {};
  const auto ratio = [&](double r) {
    return (power(b, r) - power(c, r)) / (power(a, r) - power(b, r));
  };
  double low = 1e-3, high = 20;
  if (ratio(low) < second / first) return {};  // the changes do not fall
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (ratio(middle) > second / first ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// What is left of the error of the mesh before the last one, as the recovery sees it.
double recovered_share(const MeshOutcome& before, const MeshOutcome& last) {
  if (last.recovery_error.trace() == 0) return 0;
  const double share = mean_change(last.recovery_error, last.flexibility) /
                       mean_change(before.recovery_error, last.flexibility);
  return std::clamp(share, 0.0, 0.9);
}

// The same by the rate. One better than theory's is owed to a coarse first mesh and not to be
// relied upon.
double share_by_rate(const MeshOutcome& before, const MeshOutcome& last, double rate,
                     double best_rate) {
  const double believed = std::clamp(rate, ErrorBars::slowest_rate, best_rate);
  return std::clamp(power(last, believed) / power(before, believed), 0.0, 0.9);
}

// How many times the last change remains when this share of the error before it is left.
double remaining_changes(double share) { return share / (1 - share); }

// The boundary moves from mesh to mesh, too.
bool geometry_explains(const MeshOutcome& before, const MeshOutcome& last) {
  if (before.geometry_error.size() == 0 || last.geometry_error.size() == 0) return false;
  const double change =
      std::abs(mean_change(last.flexibility - before.flexibility, last.flexibility));
  return change <= mean_change(before.geometry_error + last.geometry_error, last.flexibility);
}

void compare_with_change(const MeshOutcome& before, const MeshOutcome& last, ErrorBars& result) {
  const MatrixXd change = last.flexibility - before.flexibility;
  const double seen_share = recovered_share(before, last);
  const double share = result.observed_rate
                           ? share_by_rate(before, last, *result.observed_rate, result.best_rate)
                           : seen_share;
  result.extrapolation = remaining_changes(share) * change;
  const double recovered = mean_change(result.recovery, last.flexibility);
  // Both vanish where the elements hold the exact solution, and a change that the geometry explains
  // says nothing about them.
  if (recovered < 1e-9 || geometry_explains(before, last)) {
    result.agreement = result.calibration = 1;
    return;
  }
  result.agreement = mean_change(result.extrapolation, last.flexibility) / recovered;
  result.calibration =
      remaining_changes(seen_share) * mean_change(change, last.flexibility) / recovered;
}

// Of one load case: an estimate that falls more slowly than a crack would let it, or grows, is that
// of an error which the meshes start to see, as the warping of a rod whose facets are one element
// wide. It is enlarged by what it should have fallen.
double unseen(double before, double last, double growth, double best_rate) {
  if (!(before > 0 && last > 0) || last / before <= std::pow(growth, -ErrorBars::slowest_rate))
    return 1;
  return std::min(last / before * std::pow(growth, best_rate), ErrorBars::most_unseen);
}

// The recovery, enlarged where it has not started to fall.
MatrixXd believed(const std::vector<MeshOutcome>& sequence, double best_rate) {
  const MeshOutcome& last = sequence.back();
  if (sequence.size() < 2) return last.recovery_error;
  const MeshOutcome& before = sequence[sequence.size() - 2];
  const double growth = static_cast<double>(last.unknowns) / static_cast<double>(before.unknowns);
  Eigen::VectorXd roots(last.recovery_error.rows());
  for (Eigen::Index i = 0; i < roots.size(); ++i)
    roots[i] = std::sqrt(
        unseen(before.recovery_error(i, i), last.recovery_error(i, i), growth, best_rate));
  return roots.asDiagonal() * last.recovery_error * roots.asDiagonal();
}

MatrixXd bars(const ErrorBars& estimates, const MatrixXd& recovery) {
  const double enlarged = std::max(1.0, estimates.calibration.value_or(1));
  MatrixXd bar = ErrorBars::safety * enlarged * recovery.cwiseAbs();
  if (estimates.extrapolation.size() > 0) bar = bar.cwiseMax(estimates.extrapolation.cwiseAbs());
  const Eigen::VectorXd roots = (enlarged * recovery.diagonal()).cwiseMax(0).cwiseSqrt();
  bar += ErrorBars::cross_share * roots * roots.transpose();
  if (estimates.estimates_are_comparable())
    bar *= std::max(1.0, estimates.difference() / ErrorBars::agreement_factor);
  return bar;
}

}  // namespace

double ErrorBars::difference() const {
  if (!agreement || *agreement <= 0) return std::numeric_limits<double>::infinity();
  return std::max(*agreement, 1 / *agreement);
}

namespace {

// The largest relative bar of the significant entries.
double relative_error_of(const ErrorBars& bars, const MatrixXd& flexibility) {
  double largest = 0;
  for (Eigen::Index j = 0; j < flexibility.cols(); ++j)
    for (Eigen::Index i = 0; i < flexibility.rows(); ++i)
      if (bars.significant(i, j))
        largest = std::max(largest, bars.bar(i, j) / std::abs(flexibility(i, j)));
  return largest;
}

}  // namespace

ErrorBars error_bars(const std::vector<MeshOutcome>& sequence, int order) {
  const MeshOutcome& last = sequence.back();
  const MatrixXd& c = last.flexibility;
  ErrorBars result;
  result.recovery = last.recovery_error;
  result.best_rate = 2.0 * order / 3;
  const std::size_t count = sequence.size();
  if (count >= 3)
    result.observed_rate =
        rate_through(sequence[count - 3], sequence[count - 2], sequence[count - 1]);
  if (count >= 2) compare_with_change(sequence[count - 2], last, result);
  result.bar = bars(result, believed(sequence, result.best_rate));
  if (last.geometry_error.size() > 0) {
    const Eigen::VectorXd roots = last.geometry_error.diagonal().cwiseMax(0).cwiseSqrt();
    result.geometry = ErrorBars::safety * last.geometry_error.cwiseAbs() +
                      ErrorBars::cross_share * roots * roots.transpose();
    result.bar += result.geometry;
  }
  const Eigen::VectorXd size = c.diagonal().cwiseSqrt();
  result.significant =
      c.cwiseAbs().array() >= (ErrorBars::significance * size * size.transpose()).array();
  result.relative_error = relative_error_of(result, c);
  return result;
}

}  // namespace kinetostat::fea
