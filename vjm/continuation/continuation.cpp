#include "kinetostat/vjm/continuation/continuation.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/vjm/chain/robust_factor.h"

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int most_corrections = 12;
constexpr double largest_turn = 0.95;  // cosine of the angle between neighbouring tangents

MatrixXd bordered(const MatrixXd& derivative, const VectorXd& last_row) {
  MatrixXd matrix(derivative.rows() + 1, derivative.cols());
  matrix << derivative, last_row.transpose();
  return matrix;
}

// Of the path, unit length, on the side of `forward`.
VectorXd direction(const MatrixXd& derivative, const VectorXd& forward) {
  RobustFactor factor;
  factor.compute(bordered(derivative, forward));
  return factor.solve(VectorXd::Unit(forward.size(), forward.size() - 1)).col(0).normalized();
}

}  // namespace

std::optional<Station> Continuation::station(const PathState& at, const VectorXd& forward) {
  const LinearisedPath linear = equations_.linearised(at);
  Station station{at, direction(linear.derivative(), forward), {}};
  if (!(station.tangent.norm() > 0.5)) return std::nullopt;  // zero, or not a number
  station.spectrum = linear.spectrum();
  return station;
}

std::optional<Station> Continuation::correct(const PathState& from, const VectorXd& guess,
                                             const VectorXd& normal, double offset,
                                             const VectorXd& forward) {
  const double reach = equations_.scale().length;
  PathState at = equations_.moved(from, guess);
  VectorXd change = guess;
  double last = 0;
  for (iterations_ = 1; iterations_ <= most_corrections; ++iterations_) {
    VectorXd right(normal.size());
    right << equations_.right_hand_side(at), offset - normal.dot(change);
    RobustFactor factor;
    factor.compute(bordered(equations_.linearised(at).derivative(), normal));
    bool consistent = true;
    const VectorXd correction = factor.solve(right, &consistent);
    const double size = correction.norm();
    // At a bifurcation the last pivot is rounding: what remains is an equilibrium, and the
    // correction is arbitrary along the motion that has become free.
    const bool balanced = right.norm() <= 1e-14 * reach;
    if (balanced && iterations_ > 2 && size > 0.1 * last) return station(at, forward);
    if (!std::isfinite(size) || size > 10 * reach) return std::nullopt;
    at = equations_.moved(at, correction);
    change += correction;
    // Near a singular point corrections stop falling at rounding over the smallest pivot.
    const bool at_rounding = size <= 1e-9 * reach && size > 0.1 * last;
    if (size <= 1e-12 * reach || (iterations_ > 2 && at_rounding)) {
      if (!consistent && size > 1e-12 * reach) return std::nullopt;
      return station(at, forward);
    }
    last = size;
  }
  return std::nullopt;
}

std::optional<Station> Continuation::first(const PathState& at) {
  const MatrixXd null = null_space(equations_.linearised(at).derivative());
  const Index n = null.rows();
  VectorXd forward = null * null.row(n - 1).transpose();
  if (forward.norm() < 1e-8) {
    const VectorXd push = equations_.push();
    forward = null * (null.transpose() * push);
    if (!(forward.norm() > 1e-8 * push.norm())) return std::nullopt;
  }
  forward.normalize();
  return station(at, forward);
}

std::optional<Station> Continuation::step(const Station& from, double length) {
  std::optional<Station> next =
      correct(from.at, length * from.tangent, from.tangent, length, from.tangent);
  // At a stop the path has a kink, which no step resolves.
  const bool smallest = length <= 1e-6 * equations_.scale().length;
  if (next && !smallest && next->tangent.dot(from.tangent) < largest_turn) return std::nullopt;
  return next;
}

std::optional<Station> Continuation::between(const Station& from, const Station& to, double share) {
  const VectorXd change = share * equations_.difference(from.at, to.at);
  return correct(from.at, change, from.tangent, from.tangent.dot(change), from.tangent);
}

std::optional<Station> Continuation::at_parameter(const Station& from, const Station& to,
                                                  double parameter) {
  const VectorXd chord = equations_.difference(from.at, to.at);
  const Index n = chord.size();
  const double share = (parameter - from.at.parameter) / (to.at.parameter - from.at.parameter);
  std::optional<Station> station;
  if (std::isfinite(share))
    station = correct(from.at, share * chord, VectorXd::Unit(n, n - 1), share * chord[n - 1],
                      from.tangent);
  // Beside a limit point the parameter hardly leads anywhere, or onto the other side.
  const auto is_near = [&](const Station& found) {
    return (equations_.difference(from.at, found.at) - share * chord).norm() <= 0.5 * chord.norm();
  };
  if (!station || !is_near(*station)) station = halved_to(from, to, parameter);
  if (station) station->at.parameter = parameter;
  return station;
}

std::optional<Station> Continuation::halved_to(const Station& from, const Station& to,
                                               double parameter) {
  const bool rises = to.at.parameter > from.at.parameter;
  double low = 0, high = 1;
  Station nearest = to;
  while (high - low > 1e-14) {
    const double middle = 0.5 * (low + high);
    std::optional<Station> station = between(from, to, middle);
    if (!station) return std::nullopt;
    ((station->at.parameter < parameter) == rises ? low : high) = middle;
    nearest = std::move(*station);
  }
  return nearest;
}

MatrixXd Continuation::derivative(const Station& station) const {
  return equations_.linearised(station.at).derivative();
}

}  // namespace kinetostat::vjm
