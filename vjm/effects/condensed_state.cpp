#include "kinetostat/vjm/effects/condensed_state.h"

#include <algorithm>

namespace kinetostat::vjm {
namespace {

using Values = CondensedJoint::Values;
using Sample = CondensedJoint::Sample;

// Divided differences over two places, each taken twice: [a, b], [a, a, b] and [a, b, b].
struct Differences {
  Values slope, at_first, at_last;

  Differences(const Sample& a, const Sample& b) {
    const double width = b.x - a.x;
    slope = (b.values - a.values) / width;
    at_first = (slope - a.by_x) / width;
    at_last = (b.by_x - slope) / width;
  }
};

// Whether the curve of third degree through the outer samples leads through the middle, as it goes
// on there.
bool is_smooth(const Sample& here, const Sample& below, const Sample& above, double stiffness) {
  constexpr double alike = 1e-7;
  const Differences d(below, above);
  const double width = above.x - below.x, a = here.x - below.x, b = here.x - above.x;
  const Values third = (d.at_last - d.at_first) / width;
  const Values bend = d.at_first + b * third;
  const Values missed = below.values + a * (below.by_x + a * bend) - here.values;
  const Values turned = below.by_x + a * (2 * bend + a * third) - here.by_x;
  const double motion = (above.values - below.values).tail<6>().norm();
  const auto is_none = [&](const Values& error) {
    return std::abs(error[0]) <= 0.01 * alike * stiffness * width &&
           error.tail<6>().norm() <= alike * motion;
  };
  return is_none(missed) && is_none(width * turned);
}

}  // namespace

std::optional<CondensedJoint> CondensedJoint::through(const Sample& here, const Sample& below,
                                                      const Sample& above, double stiffness) {
  const bool is_known = below.x < 0 && above.x > 0 && here.by_x.allFinite() &&
                        below.by_x.allFinite() && above.by_x.allFinite();
  if (!is_known || !is_smooth(here, below, above, stiffness)) return std::nullopt;
  CondensedJoint joint;
  joint.ends_ = {below.x, above.x};
  // Divided differences over the nodes 0, 0, a, a, b, b.
  const double a = below.x, b = above.x;
  const Differences first(here, below), last(below, above);
  const Values over_00aa = (first.at_last - first.at_first) / a;
  const Values over_0aab = (last.at_first - first.at_last) / b;
  const Values over_aabb = (last.at_last - last.at_first) / (b - a);
  const Values over_00aab = (over_0aab - over_00aa) / b;
  const Values over_0aabb = (over_aabb - over_0aab) / b;
  joint.coefficients_ << here.values, here.by_x, first.at_first, over_00aa, over_00aab,
      (over_0aabb - over_00aab) / b;
  return joint;
}

// Of all rows or of some.
template <class Coefficients, class Value>
void CondensedJoint::evaluate(const Coefficients& coefficients, double x, Value& value,
                              Value& slope) const {
  const std::array<double, 5> nodes = {0, 0, ends_[0], ends_[0], ends_[1]};
  for (Eigen::Index i = 4; i >= 0; --i) {
    const double step = x - nodes[static_cast<std::size_t>(i)];
    slope = step * slope + value;
    value = step * value + coefficients(i);
  }
}

CondensedJoint::Sample CondensedJoint::at(double x) const {
  Sample sample{x, coefficients_.col(5), Values::Zero()};
  evaluate([this](Eigen::Index i) { return coefficients_.col(i); }, x, sample.values, sample.by_x);
  return sample;
}

CondensedJoint::Force CondensedJoint::force_at(double x) const {
  Force force{coefficients_(0, 5), 0};
  evaluate([this](Eigen::Index i) { return coefficients_(0, i); }, x, force.value, force.slope);
  return force;
}

const CondensedState::Joint* CondensedState::find(const JointPlace& place) const {
  const auto found = std::find_if(joints.begin(), joints.end(),
                                  [&](const Joint& joint) { return joint.place == place; });
  return found == joints.end() ? nullptr : &*found;
}

}  // namespace kinetostat::vjm
