// A transmission that grows stiffer with its deflection.
#include <cmath>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class CubicLaw : public CoordinateLaw {
 public:
  explicit CubicLaw(double k3) : k3_(k3) {}
  Value at(const JointState& joint) const override {
    const double d = joint.deflection;
    return {.force = k3_ * d * d * d, .tangent = 3 * k3_ * d * d};
  }
  double energy(const JointState& joint) const override {
    return k3_ * std::pow(joint.deflection, 4) / 4;
  }

 private:
  double k3_;
};

class Hardening : public EffectKind {
 public:
  Hardening() {
    name = "hardening";
    effect_class = EffectClass::stiffening;
    summary = "a joint's spring grows stiffer with its deflection";
    law = "F = k d + k3 d^3, d = deflection from rest";
    source = "cubic (Duffing) spring; Nayfeh and Mook, Nonlinear Oscillations, 1979, ch. 2";
    signature = "displacement grows less than in proportion to the load, odd in the load";
    confuser = "clearance: both are odd, but a gap acts at small loads";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {{.name = "k3",
                   .linear = {.length = -2, .mass = 1, .time = -2},
                   .angular = {.length = 2, .mass = 1, .time = -2, .angle = -3},
                   .lower = 0,
                   .upper = 1e30,
                   .prior_sd = 1,
                   .prior_unit = PriorUnit::cubic_stiffness}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    spring_of_joint(modifier.chain(), joint);
    modifier.add_law(joint, std::make_shared<CubicLaw>(input.values[0]));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    const Eigen::Index k = columns.state().chain.index_of(joint);
    const double d = columns.state().deflection[k];
    columns.add_drive_force(0, k, -d * d * d);
  }
};

}  // namespace

Kind hardening() { return std::make_shared<Hardening>(); }

}  // namespace kinetostat::vjm::effects
