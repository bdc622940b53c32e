#include "kinetostat/fea/error_bars.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinetostat::fea {
namespace {

using Eigen::MatrixXd;

// Of the strongest singularity of elasticity, a crack, on even meshes.
constexpr double slowest_rate = 1.0 / 3;

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

// What is left of the error of the mesh before the last one. A rate better than theory's is owed to
// a coarse first mesh and not to be relied upon.
double remaining_share(const std::vector<MeshOutcome>& sequence, std::optional<double> rate,
                       double best_rate) {
  const MeshOutcome &before = sequence[sequence.size() - 2], &last = sequence.back();
  double share = last.recovery_error.trace() == 0
                     ? 0
                     : mean_change(last.recovery_error, last.flexibility) /
                           mean_change(before.recovery_error, last.flexibility);
  if (rate)
    share = power(last, std::clamp(*rate, slowest_rate, best_rate)) /
            power(before, std::clamp(*rate, slowest_rate, best_rate));
  return std::clamp(share, 0.0, 0.9);
}

MatrixXd bars(const ErrorBars& estimates) {
  const MatrixXd& recovery = estimates.recovery;
  MatrixXd larger = recovery.cwiseAbs();
  if (estimates.extrapolation.size() > 0)
    larger = larger.cwiseMax(estimates.extrapolation.cwiseAbs());
  const Eigen::VectorXd roots = recovery.diagonal().cwiseMax(0).cwiseSqrt();
  return ErrorBars::safety * larger + ErrorBars::cross_share * roots * roots.transpose();
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
  if (count >= 2) {
    const double share = remaining_share(sequence, result.observed_rate, result.best_rate);
    result.extrapolation = share / (1 - share) * (c - sequence[count - 2].flexibility);
    const double recovered = mean_change(result.recovery, c);
    // Both vanish where the elements hold the exact solution.
    if (recovered < 1e-9)
      result.agreement = 1;
    else
      result.agreement = mean_change(result.extrapolation, c) / recovered;
  }
  result.bar = bars(result);
  const Eigen::VectorXd size = c.diagonal().cwiseSqrt();
  result.significant =
      c.cwiseAbs().array() >= (ErrorBars::significance * size * size.transpose()).array();
  for (Eigen::Index j = 0; j < c.cols(); ++j)
    for (Eigen::Index i = 0; i < c.rows(); ++i)
      if (result.significant(i, j))
        result.relative_error =
            std::max(result.relative_error, result.bar(i, j) / std::abs(c(i, j)));
  return result;
}

}  // namespace kinetostat::fea
