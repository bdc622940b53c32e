// Bearings and guides yield across the motion that they leave free.
#include <array>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace bearing_compliance_kind {
namespace {

enum Value { radial, axial, tilt };

class BearingCompliance : public EffectKind {
 public:
  BearingCompliance() {
    const auto parameter = [](const char* called, const spatial::Dimension& dimension) {
      return EffectParameter{.name = called,
                             .linear = dimension,
                             .angular = dimension,
                             .lower = 0,
                             .upper = 1,
                             .prior_sd = 0.1,
                             .prior_unit = PriorUnit::soft_compliance,
                             .required = false};
    };
    name = "bearing_compliance";
    effect_class = EffectClass::compliance;
    summary = "a joint yields across its motion: radially, along its axis, and in tilt";
    law =
        "u = c F for the two radial displacements (radial), that along the axis (axial, where the "
        "joint turns), and rotations other than its own (tilt); relative to the axes of the joint";
    source = "passive joints with elastic constraints: MMT11 section 2; JAMRIS09 eq. 1";
    signature = "displacement across the joint's axis, in proportion to the load, at all postures";
    confuser = "link_compliance of the link behind the joint";
    place = EffectPlace::joint;
    parameters = {parameter("radial", compliance::linear), parameter("axial", compliance::linear),
                  parameter("tilt", compliance::angular)};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Eigen::Index k = modifier.chain().index_of(joint);
    const Motion own = modifier.chain().coordinates()[static_cast<std::size_t>(k)].motion;
    if (!is_rotation(own) && input.values[axial] != 0)
      throw std::invalid_argument(
          fmt::format("joint '{}' slides: along its axis its drive yields, not a bearing", joint));
    for (const Motion motion : all_motions)
      if (const auto value = value_of(motion, own))
        modifier.add_compliance_behind(joint, coordinate_name(joint, motion), motion,
                                       input.values[*value]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    const Chain& chain = columns.state().chain;
    const Motion own = chain.coordinates()[static_cast<std::size_t>(chain.index_of(joint))].motion;
    for (const Motion motion : all_motions)
      if (const auto value = value_of(motion, own))
        columns.add_compliance_behind(*value, joint, coordinate_name(joint, motion), motion, 1);
  }

 private:
  // Which value a motion yields by; none for the joint's own.
  static std::optional<Value> value_of(Motion motion, Motion own) {
    if (motion == own) return std::nullopt;
    if (is_rotation(motion)) return tilt;
    return axis_index(motion) == axis_index(own) ? axial : radial;
  }
  static std::string coordinate_name(const std::string& joint, Motion motion) {
    return "bearing of " + joint + "." + to_string(motion);
  }
};

}  // namespace
}  // namespace bearing_compliance_kind

Kind bearing_compliance() { return std::make_shared<bearing_compliance_kind::BearingCompliance>(); }

}  // namespace kinetostat::vjm::effects
