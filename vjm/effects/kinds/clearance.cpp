// Play in series with the spring of a joint.
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// Width of the rounded corners of the dead zone over its half width. With sharp ones a joint inside
// its gap has no stiffness at all, and the derivatives jump.
constexpr double rounding = 0.2;

// What the gap takes from the linear spring k d: together they give k times the dead zone.
class GapLaw : public CoordinateLaw {
 public:
  explicit GapLaw(double gap) : gap_(gap) {}
  Value at(const JointState& joint) const override {
    const double d = joint.deflection, k = joint.stiffness;
    const DeadZone zone(d, gap_, rounding * gap_);
    return {.energy = k * (zone.integral - d * d / 2),
            .force = k * (zone.value - d),
            .tangent = k * (zone.slope - 1),
            .force_by_stiffness = zone.value - d};
  }

 private:
  double gap_;
};

class Clearance : public EffectKind {
 public:
  Clearance() {
    name = "clearance";
    effect_class = EffectClass::backlash;
    summary = "play in series with the spring of a joint";
    law =
        "F = k dead(d, gap): 0 for |d| < gap, k (d -+ gap) beyond; the corners are rounded over "
        "0.2 gap";
    source =
        "dead zone of a transmission: Nordin and Gutman, Controlling mechanical systems with "
        "backlash, Automatica 38 (2002) 1633";
    signature = "a jump of twice the gap where the load changes its sign, none at high load";
    confuser = "hardening, and friction when the load does not reverse";
    place = EffectPlace::joint;
    parameters = {{.name = "gap",
                   .linear = spatial::dimension::length,
                   .angular = spatial::dimension::angle,
                   .lower = 0,
                   .upper = 0.1,
                   .prior_sd = 0.1,
                   .prior_unit = PriorUnit::joint_play}};
  }

  void act(Chain& chain, const std::string& joint, const EffectInput& input) const override {
    spring_of_joint(chain, joint);
    chain.law(joint, std::make_shared<GapLaw>(input.values[0]));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const ChainState& state = columns.state();
    const Spring& spring = spring_of_joint(state.chain, joint);
    const double gap = input.values[0];
    const DeadZone zone(state.deflection[spring.first], gap, rounding * gap);
    columns.add_drive_force(0, spring.first,
                            -spring.stiffness(0, 0) * (zone.by_gap + rounding * zone.by_width));
  }
};

}  // namespace

Kind clearance() { return std::make_shared<Clearance>(); }

}  // namespace kinetostat::vjm::effects
