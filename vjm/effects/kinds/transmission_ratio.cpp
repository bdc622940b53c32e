// A drive that moves its joint too far or not far enough, in one proportion.
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace transmission_ratio_kind {
namespace {

class TransmissionRatio : public EffectKind {
 public:
  TransmissionRatio() {
    name = "transmission_ratio";
    effect_class = EffectClass::geometry;
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    summary = "a drive that moves its joint too far or not far enough: the pitch of a screw";
    law = "rest value = u + ratio (u - home) for the command u";
    source = "mean bi-directional positional deviation growing along an axis: ISO 230-2";
    signature = "an offset in proportion to the joint's command, whatever the load";
    confuser = "thermal_expansion of a screw; sensor_scale, where one axis moves";
    least_commands = 3;  // an offset, the ratio, and one to see whether it is so
    parameters = {{.name = "ratio",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = -0.1,
                   .upper = 0.1,
                   .prior_sd = 3e-4}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Eigen::Index k = modifier.chain().index_of(joint);
    lead_by_ratio(modifier, k, k, input.values[0]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    const Eigen::Index k = columns.state().chain.index_of(joint);
    add_ratio(columns, 0, k, k);
  }
};

}  // namespace
}  // namespace transmission_ratio_kind

Kind transmission_ratio() { return std::make_shared<transmission_ratio_kind::TransmissionRatio>(); }

}  // namespace kinetostat::vjm::effects
