// A further compliance in series with the spring of a joint: a shaft, a coupling, a soft mount.
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class JointCompliance : public EffectKind {
 public:
  JointCompliance() {
    name = "joint_compliance";
    effect_class = EffectClass::compliance;
    summary = "further compliance in series with the spring of a joint";
    law = "1/k = 1/k0 + c";
    source = "springs in series; MMT11 section 3";
    signature = "displacement along the joint's motion, in proportion to the load";
    confuser =
        "piecewise_stiffness while the load stays on one slope; link_compliance of the next link";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {{.name = "c",
                   .linear = {.mass = -1, .time = 2},
                   .angular = {.length = -2, .mass = -1, .time = 2, .angle = 1},
                   .lower = 0,
                   .upper = 1,
                   .prior_sd = 0.3,
                   .prior_unit = PriorUnit::compliance}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    modifier.add_series_compliance(joint, input.values[0]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    add_series_compliance(columns, 0, spring_of_joint(columns.state().chain, joint).first, 1);
  }
};

}  // namespace

// dk/dc = -k^2 with the k of all compliances in series; laws beside it know this k, too.
void add_series_compliance(ChainColumns& columns, Eigen::Index column, Eigen::Index k,
                           double change) {
  const ChainState& state = columns.state();
  double of_drive = state.deflection[k], beside = 0;
  for (const auto& [coordinate, law] : state.chain.laws())
    if (coordinate == k)
      (law->is_beside_drive() ? beside : of_drive) +=
          state.chain.value_of(k, *law, state.x, state.deflection, state.travel).force_by_stiffness;
  const double rate = change * state.chain.stiffness()(k, k) * state.chain.stiffness()(k, k);
  columns.add_drive_force(column, k, rate * of_drive);
  columns.add_force(column, k, rate * beside);
}

Kind joint_compliance() { return std::make_shared<JointCompliance>(); }

}  // namespace kinetostat::vjm::effects
