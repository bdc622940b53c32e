// Play in series with the spring of a joint, by itself or with a constant load that holds the joint
// to one side of it.
#include <optional>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace clearance_kind {
namespace {

// Width of the rounded corners of the dead zone over its half width: of flanks that yield, and of
// hard ones. Without any a joint inside its gap has no stiffness at all, and the derivatives jump.
constexpr double rounding = 0.2, rounding_of_sharp = 0.05;

double rounding_of(double sharp) { return sharp > 0.5 ? rounding_of_sharp : rounding; }

EffectParameter gap_parameter() {
  return {.name = "gap",
          .linear = spatial::dimension::length,
          .angular = spatial::dimension::angle,
          .lower = 0,
          .upper = 0.1,
          .prior_sd = 0.1,
          .prior_unit = PriorUnit::joint_play};
}

// What the gap takes from the linear spring k d, whose drive bears `bias` beside what the joint
// does: together they give k dead(d + bias / k, gap) - bias.
class GapLaw : public CoordinateLaw {
 public:
  GapLaw(double gap, double bias, double rounding)
      : gap_(gap), bias_(bias), width_(rounding * gap) {}
  Value at(const JointState& joint) const override {
    const double d = joint.deflection, k = joint.stiffness, shift = bias_ / k;
    const DeadZone zone(d + shift, gap_, width_);
    return {.force = k * (zone.value - d) - bias_,
            .tangent = k * (zone.slope - 1),
            .force_by_stiffness = zone.value - d - shift * zone.slope};
  }
  double energy(const JointState& joint) const override {
    const double d = joint.deflection, k = joint.stiffness;
    return k * (DeadZone(d + bias_ / k, gap_, width_).integral() - d * d / 2) - bias_ * d;
  }
  // Between the gap and its flanks; from the gap no farther than to where a flank starts to hold.
  bool kinks(const JointState& from, double& step) const override {
    if (width_ > rounding_of_sharp * gap_) return false;
    const auto side = [this](double d) { return d > gap_ ? 1 : d < -gap_ ? -1 : 0; };
    const double d = from.deflection + bias_ / from.stiffness;
    const int start = side(d), end = side(d + step);
    if (start == 0 && end != 0) step = end * gap_ - d;
    return start != end;
  }

 private:
  double gap_, bias_, width_;
};

void add_gap(ChainModifier& modifier, const std::string& joint, double gap, double bias,
             double sharp) {
  spring_of_joint(modifier.chain(), joint);
  modifier.add_law(joint, std::make_shared<GapLaw>(gap, bias, rounding_of(sharp)));
}

// By the gap in column 0, by the bias in column 1 where there is one.
void differentiate_gap(ChainColumns& columns, const std::string& joint, double gap,
                       std::optional<double> bias, double sharp) {
  const ChainState& state = columns.state();
  const Spring& spring = spring_of_joint(state.chain, joint);
  const double k = spring.stiffness(0, 0);
  const double width = rounding_of(sharp);
  const DeadZone zone(state.deflection[spring.first] + bias.value_or(0) / k, gap, width * gap);
  columns.add_drive_force(0, spring.first, -k * (zone.by_gap + width * zone.by_width));
  if (bias) columns.add_drive_force(1, spring.first, 1 - zone.slope);
}

class Clearance : public EffectKind {
 public:
  Clearance() {
    name = "clearance";
    effect_class = EffectClass::backlash;
    summary = "play in series with the spring of a joint";
    law =
        "F = k dead(d, gap): 0 for |d| < gap, k (d -+ gap) beyond; the corners are rounded over "
        "0.2 gap, with sharp = 1 over 0.05 gap";
    source =
        "dead zone of a transmission: Nordin and Gutman, Controlling mechanical systems with "
        "backlash, Automatica 38 (2002) 1633";
    signature = "a jump of twice the gap where the load changes its sign, none at high load";
    confuser = "hardening, and friction when the load does not reverse";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {gap_parameter(), either_way("sharp", "between hard flanks")};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    add_gap(modifier, joint, input.values[0], 0, input.values[1]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    differentiate_gap(columns, joint, input.values[0], std::nullopt, input.values[1]);
  }
};

class BiasedClearance : public EffectKind {
 public:
  BiasedClearance() {
    name = "biased_clearance";
    effect_class = EffectClass::backlash;
    summary = "play in series with the spring of a joint that a constant load holds to one side";
    law =
        "F = k dead(d + bias/k, gap) - bias: the gap is crossed where the load is -bias; bias "
        "itself deflects nothing; sharp as of clearance";
    source =
        "gears loaded to one flank by weight or by a spring: Nordin and Gutman, Controlling "
        "mechanical systems with backlash, Automatica 38 (2002) 1633";
    signature = "a jump of twice the gap at one joint force, -bias, whatever the direction";
    confuser = "clearance, whose jump is at zero; piecewise_stiffness";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {gap_parameter(),
                  {.name = "bias",
                   .linear = spatial::dimension::force,
                   .angular = spatial::dimension::moment,
                   .lower = -1e9,
                   .upper = 1e9,
                   .prior_sd = 0.2,
                   .prior_unit = PriorUnit::joint_load,
                   .is_shape = true},
                  either_way("sharp", "between hard flanks")};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    add_gap(modifier, joint, input.values[0], input.values[1], input.values[2]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    differentiate_gap(columns, joint, input.values[0], input.values[1], input.values[2]);
  }
};

}  // namespace
}  // namespace clearance_kind

Kind biased_clearance() { return std::make_shared<clearance_kind::BiasedClearance>(); }
Kind clearance() { return std::make_shared<clearance_kind::Clearance>(); }

}  // namespace kinetostat::vjm::effects
