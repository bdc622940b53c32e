// A transmission that grows stiffer with its load: contacts that close, flanks that come to bear.
#include <cmath>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// Compliance under load over that without, where the law ends: beyond, the spring stays as stiff as
// there, for none becomes rigid.
constexpr double stiffest = 0.1;

// The force F of d = F/k - b F^2 at one deflection d >= 0, its derivatives, and its integral over
// d.
struct Force {
  double value, slope, by_stiffness, by_b, energy;

  Force(double d, double k, double b) {
    const double rest = 1 - 4 * b * k * k * d;
    const bool beyond = rest < stiffest * stiffest;
    const double s = beyond ? stiffest : std::sqrt(rest);  // compliance over 1/k
    const double end = beyond ? (1 - s * s) / (4 * b * k * k) : d;
    value = 2 * k * end / (1 + s);
    energy = value * end - value * value / (2 * k) + b * value * value * value / 3;
    slope = k / s;
    by_stiffness = value / (k * s);
    by_b = k * value * value / s;
    if (!beyond) return;
    // The end of the law moves with k and b: its force as 1/(k b), its deflection as 1/(k^2 b).
    by_stiffness = -value / k + (d - end) / s + 2 * end / s;
    by_b = -value / b + slope * end / b;
    energy += value * (d - end) + slope * (d - end) * (d - end) / 2;
    value += slope * (d - end);
  }
};

class LoadLaw : public CoordinateLaw {
 public:
  explicit LoadLaw(double b) : b_(b) {}
  Value at(const JointState& joint) const override {
    const double d = std::abs(joint.deflection), k = joint.stiffness;
    const double sign = joint.deflection < 0 ? -1 : 1;
    const Force force(d, k, b_);
    return {.force = sign * (force.value - k * d),
            .tangent = force.slope - k,
            .force_by_stiffness = sign * (force.by_stiffness - d)};
  }
  double energy(const JointState& joint) const override {
    const double d = std::abs(joint.deflection), k = joint.stiffness;
    return Force(d, k, b_).energy - k * d * d / 2;
  }

 private:
  double b_;
};

class LoadHardening : public EffectKind {
 public:
  LoadHardening() {
    name = "load_hardening";
    effect_class = EffectClass::stiffening;
    summary = "a joint's compliance falls with its load";
    law =
        "d = F/k - b F |F|; where the compliance has fallen to a tenth, the spring stays as stiff "
        "as it is there";
    source =
        "quadratic calibration curve of load cells: NIST StRD, Pontius; NIST/SEMATECH e-Handbook, "
        "section 4.6.2";
    signature = "displacement grows less than in proportion to the load, by its square";
    confuser = "hardening, whose stiffness rises with the square of the deflection";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {{.name = "b",
                   .linear = {.length = -1, .mass = -2, .time = 4},
                   .angular = {.length = -4, .mass = -2, .time = 4, .angle = 1},
                   .lower = 0,
                   .upper = 1,
                   .prior_sd = 0.05,
                   .prior_unit = PriorUnit::load_compliance}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    spring_of_joint(modifier.chain(), joint);
    modifier.add_law(joint, std::make_shared<LoadLaw>(input.values[0]));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const Spring& spring = spring_of_joint(columns.state().chain, joint);
    const double d = columns.state().deflection[spring.first];
    const Force force(std::abs(d), spring.stiffness(0, 0), input.values[0]);
    columns.add_drive_force(0, spring.first, d < 0 ? force.by_b : -force.by_b);
  }
};

}  // namespace

Kind load_hardening() { return std::make_shared<LoadHardening>(); }

}  // namespace kinetostat::vjm::effects
