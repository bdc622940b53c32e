// Joints that are softer, or stiffer, on one side: other flanks or branches in each direction, and
// contacts that a load opens.
#include <cmath>
#include <optional>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace one_sided_stiffness_kind {
namespace {

// Width of the rounded corner over the deflection at which a contact opens.
constexpr double rounding = 0.1;

enum Value { ratio, force };

// max(x, 0) with a hyperbola for a corner, (x + sqrt(x^2 + w^2)) / 2: value, slope, derivative by
// w, integral over x.
struct Ramp {
  double x, w, r, value, slope, by_width;

  Ramp(double at, double width) : x(at), w(width), r(std::sqrt(x * x + w * w)) {
    value = (x + r) / 2;
    slope = r > 0 ? (1 + x / r) / 2 : 0.5;
    by_width = r > 0 ? w / (2 * r) : 0.5;
  }
  double integral() const {
    const double curved = w > 0 ? w * w * std::asinh(x / w) : 0;
    return (x * x + x * r + curved) / 4;
  }
};

// The deflection beyond the corner, counted from no deflection: side [R(side d - d0) - R(-d0)], d0
// = |force| / k.
struct Beyond {
  double side, corner;
  Ramp here, none;

  Beyond(double d, double opening, double k)
      : side(opening < 0 ? -1 : 1),
        corner(std::abs(opening) / k),
        here(side * d - corner, rounding * corner),
        none(-corner, rounding * corner) {}

  double value() const { return side * (here.value - none.value); }
  double slope() const { return here.slope; }
  double by_corner() const {
    return side * (none.slope - here.slope + rounding * (here.by_width - none.by_width));
  }
  double integral(double d) const {
    return here.integral() - none.integral() - none.value * side * d;
  }
};

// What is added to the linear spring k d: (ratio - 1) k beyond the corner.
class OneSidedLaw : public CoordinateLaw {
 public:
  OneSidedLaw(double ratio, double opening) : step_(ratio - 1), opening_(opening) {}

  Value at(const JointState& joint) const override {
    const double k = joint.stiffness;
    const Beyond beyond(joint.deflection, opening_, k);
    return {.force = step_ * k * beyond.value(),
            .tangent = step_ * k * beyond.slope(),
            .force_by_stiffness = step_ * (beyond.value() - beyond.corner * beyond.by_corner())};
  }
  double energy(const JointState& joint) const override {
    const double k = joint.stiffness;
    return step_ * k * Beyond(joint.deflection, opening_, k).integral(joint.deflection);
  }
  bool kinks(const JointState& from, double& step) const override {
    const double corner = opening_ / from.stiffness;
    // At the corner the tangent is that of neither side.
    if (std::abs(from.deflection - corner) < 1e-6 * std::abs(step)) return true;
    return (from.deflection < corner) != (from.deflection + step < corner);
  }

 private:
  double step_, opening_;
};

void add_one_sided(ChainModifier& modifier, const std::string& joint, double ratio,
                   double opening) {
  spring_of_joint(modifier.chain(), joint);
  modifier.add_law(joint, std::make_shared<OneSidedLaw>(ratio, opening));
}

// By the ratio in column 0, by the load of the corner in column 1 where there is one.
void differentiate_one_sided(ChainColumns& columns, const std::string& joint, double ratio,
                             std::optional<double> opening) {
  const Spring& spring = spring_of_joint(columns.state().chain, joint);
  const double k = spring.stiffness(0, 0);
  const Beyond beyond(columns.state().deflection[spring.first], opening.value_or(0), k);
  columns.add_drive_force(Value::ratio, spring.first, -k * beyond.value());
  if (opening)
    columns.add_drive_force(Value::force, spring.first,
                            -(ratio - 1) * beyond.side * beyond.by_corner());
}

EffectParameter ratio_parameter() {
  return {.name = "ratio",
          .linear = spatial::dimension::none,
          .angular = spatial::dimension::none,
          .lower = 0.05,
          .upper = 20,
          .prior_sd = 0.5,
          .none = 1};
}

class DirectionalStiffness : public EffectKind {
 public:
  DirectionalStiffness() {
    name = "directional_stiffness";
    effect_class = EffectClass::stiffening;
    summary = "a joint whose spring has another stiffness in each direction";
    law = "F = k d for d < 0, ratio k d for d > 0";
    source =
        "bilinear spring: Shaw and Holmes, A periodically forced piecewise linear oscillator, J. "
        "Sound Vib. 90 (1983) 129";
    signature = "another slope for each sign of the load: a part of the displacement is even in it";
    confuser = "opening_contact, whose corner is not at zero; preload with hardening";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {ratio_parameter()};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    add_one_sided(modifier, joint, input.values[ratio], 0);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    differentiate_one_sided(columns, joint, input.values[ratio], std::nullopt);
  }
};

class OpeningContact : public EffectKind {
 public:
  OpeningContact() {
    name = "opening_contact";
    effect_class = EffectClass::stiffening;
    summary = "a contact that a load opens: a loose bolt, a foot that lifts, a guide that tilts";
    law =
        "dF/dd = k up to the load `force`, of either sign, ratio k beyond it; the corner is "
        "rounded over 0.1 of the deflection there";
    source =
        "preloaded joints beyond their separation load: VDI 2230-1; Johnson, Contact Mechanics, "
        "1985, section 4.4";
    signature = "softer from one load on, in one direction only";
    confuser = "directional_stiffness; piecewise_stiffness, whose corners lie on both sides";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {ratio_parameter(),
                  {.name = "force",
                   .linear = spatial::dimension::force,
                   .angular = spatial::dimension::moment,
                   .lower = -1e9,
                   .upper = 1e9,
                   .prior_sd = 0.4,
                   .prior_unit = PriorUnit::joint_load,
                   .is_shape = true}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    add_one_sided(modifier, joint, input.values[ratio], input.values[force]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    differentiate_one_sided(columns, joint, input.values[ratio], input.values[force]);
  }
};

}  // namespace
}  // namespace one_sided_stiffness_kind

Kind directional_stiffness() {
  return std::make_shared<one_sided_stiffness_kind::DirectionalStiffness>();
}
Kind opening_contact() { return std::make_shared<one_sided_stiffness_kind::OpeningContact>(); }

}  // namespace kinetostat::vjm::effects
