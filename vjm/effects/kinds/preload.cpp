// A constant force in a joint: a spring, a brake, a bearing set with force.
#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class ConstantForce : public CoordinateLaw {
 public:
  explicit ConstantForce(double force) : force_(force) {}
  Value at(const JointState&) const override { return {.force = -force_, .tangent = 0}; }
  double energy(const JointState& joint) const override { return -force_ * joint.travel; }
  bool is_beside_drive() const override { return true; }

 private:
  double force_;
};

class Preload : public EffectKind {
 public:
  Preload() {
    name = "preload";
    effect_class = EffectClass::preload;
    moves_like = EffectClass::geometry;
    summary = "a constant force that drives a joint in its positive direction";
    law = "F = k d - force";
    source = "MMT11 eq. 2: passive joints with preloaded springs";
    signature = "an offset without load; internal loads change the stiffness of closed loops";
    confuser = "eccentricity or geometric_error of the joint; the zero offset of the session";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {{.name = "force",
                   .linear = spatial::dimension::force,
                   .angular = spatial::dimension::moment,
                   .lower = -1e6,
                   .upper = 1e6,
                   .prior_sd = 0.2,
                   .prior_unit = PriorUnit::joint_load}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    require_mobile(modifier.chain(), joint);
    modifier.add_law(joint, std::make_shared<ConstantForce>(input.values[0]));
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    columns.add_force(0, columns.state().chain.index_of(joint), 1);
  }
};

}  // namespace

void require_mobile(const Chain& chain, const std::string& joint) {
  const auto& free = chain.free_coordinates();
  if (std::find(free.begin(), free.end(), chain.index_of(joint)) == free.end())
    throw std::invalid_argument(fmt::format(
        "joint '{}' of chain '{}' is rigid: a force in it moves nothing", joint, chain.name()));
}

Kind preload() { return std::make_shared<Preload>(); }

}  // namespace kinetostat::vjm::effects
