// A transmission whose stiffness rises in steps: a gear with three branches K1, K2, K3.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace piecewise_stiffness_kind {
namespace {

// Width of the rounded corners over the deflection at the first of them.
constexpr double rounding = 0.1;

enum Value { ratio2, ratio3, force1, force2 };

// Corners of the branches for a first stiffness k, and what they depend on.
struct Corners {
  double d1, d2, width;

  Corners(const Eigen::VectorXd& values, double k)
      : d1(values[force1] / k),
        d2(d1 + (values[force2] - values[force1]) / (values[ratio2] * k)),
        width(rounding * d1) {}
};

// Everything of F = k [d + (r2 - 1) dead(d, d1) + (r3 - r2) dead(d, d2)] at one deflection.
struct Branches {
  Corners at;
  DeadZone first, second;

  Branches(double d, const Eigen::VectorXd& values, double k)
      : at(values, k), first(d, at.d1, at.width), second(d, at.d2, at.width) {}
};

class BranchLaw : public CoordinateLaw {
 public:
  explicit BranchLaw(Eigen::VectorXd values) : values_(std::move(values)) {}

  Value at(const JointState& joint) const override {
    const double k = joint.stiffness;
    const Branches b(joint.deflection, values_, k);
    const double step2 = values_[ratio2] - 1, step3 = values_[ratio3] - values_[ratio2];
    const double force = k * (step2 * b.first.value + step3 * b.second.value);
    // All corners are inversely proportional to k.
    const double by_corners = step2 * (b.first.by_gap * b.at.d1 + b.first.by_width * b.at.width) +
                              step3 * (b.second.by_gap * b.at.d2 + b.second.by_width * b.at.width);
    return {.force = force,
            .tangent = k * (step2 * b.first.slope + step3 * b.second.slope),
            .force_by_stiffness = force / k - by_corners};
  }
  double energy(const JointState& joint) const override {
    const double k = joint.stiffness;
    const Branches b(joint.deflection, values_, k);
    return k * ((values_[ratio2] - 1) * b.first.integral() +
                (values_[ratio3] - values_[ratio2]) * b.second.integral());
  }

 private:
  Eigen::VectorXd values_;
};

class PiecewiseStiffness : public EffectKind {
 public:
  PiecewiseStiffness() {
    name = "piecewise_stiffness";
    effect_class = EffectClass::stiffening;
    summary = "a transmission whose stiffness changes in steps with its load: K1, K2, K3";
    law =
        "dF/dd = k below force1, ratio2 k between force1 and force2, ratio3 k beyond; the corners "
        "are rounded over 0.1 of the deflection at force1";
    source =
        "branches K1, K2, K3 of strain wave gears: Harmonic Drive AG, Engineering Data, torsional "
        "stiffness";
    signature = "displacement against load has kinks at the same joint force either way";
    confuser = "hardening, whose slope changes smoothly";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    const auto ratio = [](const char* called) {
      return EffectParameter{.name = called,
                             .linear = spatial::dimension::none,
                             .angular = spatial::dimension::none,
                             .lower = 0.05,
                             .upper = 20,
                             .prior_sd = 0.5,
                             .none = 1,
                             .required = false};
    };
    const auto force = [](const char* called, double lower, double upper, double usual) {
      return EffectParameter{.name = called,
                             .linear = spatial::dimension::force,
                             .angular = spatial::dimension::moment,
                             .lower = lower,
                             .upper = upper,
                             .prior_sd = usual,
                             .prior_unit = PriorUnit::joint_load,
                             .is_shape = true};
    };
    // The second is above the first where both are at a bound.
    parameters = {ratio("ratio2"), ratio("ratio3"), force("force1", 1e-12, 1e9, 0.1),
                  force("force2", 2e-12, 2e9, 0.4)};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    spring_of_joint(modifier.chain(), joint);
    if (!(input.values[force2] > input.values[force1]))
      throw std::invalid_argument(
          fmt::format("piecewise_stiffness of joint '{}' needs force2 above force1", joint));
    modifier.add_law(joint, std::make_shared<BranchLaw>(input.values));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const Spring& spring = spring_of_joint(columns.state().chain, joint);
    const double k = spring.stiffness(0, 0);
    const Eigen::VectorXd& v = input.values;
    const Branches b(columns.state().deflection[spring.first], v, k);
    const double step2 = v[ratio2] - 1, step3 = v[ratio3] - v[ratio2];
    const double by_d1 =
        step2 * b.first.by_gap + rounding * (step2 * b.first.by_width + step3 * b.second.by_width);
    const double by_d2 = step3 * b.second.by_gap;
    const double d2_by_ratio2 = -(v[force2] - v[force1]) / (v[ratio2] * v[ratio2] * k);
    const auto add = [&](Value value, double force) {
      columns.add_drive_force(value, spring.first, -k * force);
    };
    add(ratio2, b.first.value - b.second.value + by_d2 * d2_by_ratio2);
    add(ratio3, b.second.value);
    add(force1, by_d1 / k + by_d2 * (1 - 1 / v[ratio2]) / k);
    add(force2, by_d2 / (v[ratio2] * k));
  }
};

}  // namespace
}  // namespace piecewise_stiffness_kind

Kind piecewise_stiffness() {
  return std::make_shared<piecewise_stiffness_kind::PiecewiseStiffness>();
}

}  // namespace kinetostat::vjm::effects
