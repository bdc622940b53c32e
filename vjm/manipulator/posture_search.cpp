#include "kinetostat/vjm/manipulator/posture_search.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kinetostat::vjm {

using Eigen::Index;
using Eigen::VectorXd;
using spatial::Pose;
using spatial::Vector6;

namespace {

// A point of the van der Corput sequence: a deterministic scatter over (-1, 1).
double scatter(int index, int dimension) {
  static constexpr int primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  const int base = primes[dimension % 12];
  double value = 0, digit = 1.0 / base;
  for (int i = index + dimension / 12; i > 0; i /= base, digit /= base) value += digit * (i % base);
  return 2 * value - 1;
}

}  // namespace

PostureAccuracy posture_accuracy(double length, const Pose& target, const PostureOptions& options) {
  const double sought = std::max(options.tolerance, 1e-13 * (length + target.position().norm()));
  return {sought, std::max(sought, closed_loop_error * length)};
}

double search_length(const Chain& chain, const VectorXd& x, ChainKinematics& kinematics) {
  evaluate(chain, x, kinematics);
  return kinematics.reach > 0 ? kinematics.reach : 1.0;
}

VectorXd starting_point(const Chain& chain, int start, double length) {
  VectorXd x = chain.home();
  if (start == 0) return x;
  int dimension = 0;
  for (const Index k : chain.posture_coordinates()) {
    const bool turns = is_rotation(chain.coordinates()[static_cast<std::size_t>(k)].motion);
    x[k] += (turns ? 3.0 : length) * scatter(start, dimension++);
  }
  return x;
}

std::string miss_text(const std::string& chain, const Vector6& error) {
  return fmt::format(
      "chain '{}' cannot reach the pose: the nearest it comes is {:.4g} mm and {:.4g} deg away",
      chain, 1e3 * error.head<3>().norm(), error.tail<3>().norm() * 180 / M_PI);
}

void note_miss(const Chain& chain, const Vector6& error, PostureResult& result) {
  result.reached = false;
  if (!result.reason.empty() && error.norm() <= result.error.norm()) return;
  result.error = error;
  result.reason = miss_text(chain.name(), error);
}

}  // namespace kinetostat::vjm
