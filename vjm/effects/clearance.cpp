// Play in series with the spring of a joint.
#include <cmath>

#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// Width of the rounded corners of the dead zone over its half width. With sharp ones a joint inside
// its gap has no stiffness at all, and the derivatives jump.
constexpr double rounding = 0.2;

// The dead zone with hyperbolas for corners: its value, slope, derivative by the half gap, and
// integral over d.
struct DeadZone {
  double value = 0, slope = 0, by_gap = 0, integral = 0;

  DeadZone(double d, double gap) {
    const double w = rounding * gap;
    const double above = std::hypot(d - gap, w), below = std::hypot(d + gap, w);
    if (gap == 0) {
      *this = {};
      value = d;
      slope = 1;
      by_gap = 0;
      integral = d * d / 2;
      return;
    }
    value = d + (above - below) / 2;
    slope = 1 + ((d - gap) / above - (d + gap) / below) / 2;
    by_gap = ((-(d - gap) + rounding * w) / above - ((d + gap) + rounding * w) / below) / 2;
    const auto primitive = [w](double u, double r) {
      return (u * r + w * w * std::asinh(u / w)) / 2;
    };
    const double zero = primitive(gap, std::hypot(gap, w));
    integral =
        d * d / 2 + (primitive(d - gap, above) + zero - primitive(d + gap, below) + zero) / 2;
  }

 private:
  DeadZone() = default;
};

// What the gap takes from the linear spring k d: together they give k times the dead zone.
class Clearance : public CoordinateLaw {
 public:
  explicit Clearance(double gap) : gap_(gap) {}
  Value at(const JointState& joint) const override {
    const double d = joint.deflection, k = joint.stiffness;
    const DeadZone zone(d, gap_);
    return {.energy = k * (zone.integral - d * d / 2),
            .force = k * (zone.value - d),
            .tangent = k * (zone.slope - 1),
            .force_by_stiffness = zone.value - d};
  }

 private:
  double gap_;
};

Chain applied(const Chain& chain, const std::string& joint, const Eigen::VectorXd& values) {
  spring_of_joint(chain, joint);
  return Chain(chain).law(joint, std::make_shared<Clearance>(values[0]));
}

Eigen::MatrixXd force_derivatives(const EffectState& state, const std::string& joint,
                                  const Eigen::VectorXd& values) {
  const Spring& spring = spring_of_joint(state.chain, joint);
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(state.chain.size(), 1);
  derivatives(spring.first, 0) =
      -spring.stiffness(0, 0) * DeadZone(state.deflection[spring.first], values[0]).by_gap;
  return derivatives;
}

}  // namespace

EffectKind clearance() {
  return {.name = "clearance",
          .summary = "play in series with the spring of a joint",
          .law =
              "F = k dead(d, gap): 0 for |d| < gap, k (d -+ gap) beyond; the corners are "
              "rounded over 0.2 gap",
          .source =
              "dead zone of a transmission: Nordin and Gutman, Controlling mechanical systems "
              "with backlash, Automatica 38 (2002) 1633",
          .signature = "a jump of twice the gap where the load changes its sign, none at high load",
          .confuser = "hardening, and friction when the load does not reverse",
          .place = EffectPlace::joint,
          .parameters = {{.name = "gap",
                          .linear = spatial::dimension::length,
                          .angular = spatial::dimension::angle,
                          .lower = 0,
                          .upper = 0.1,
                          .prior_sd = 1e-4}},
          .applied = applied,
          .force_derivatives = force_derivatives};
}

}  // namespace kinetostat::vjm::effects
