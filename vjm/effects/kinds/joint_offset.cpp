// A drive whose zero is not where it is taken to be.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class JointOffset : public EffectKind {
 public:
  JointOffset() {
    name = "joint_offset";
    effect_class = EffectClass::geometry;
    is_exact = true;
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    summary = "a drive whose zero is not where it is taken to be: an encoder, a reference switch";
    law = "rest value = u + offset for the command u";
    source =
        "joint offsets: Mooring, Roth and Driels, Fundamentals of Manipulator Calibration, "
        "Wiley 1991";
    signature = "all poses stand as if the joint had been commanded elsewhere, whatever the load";
    confuser = "preload, which drives the joint as far on its spring; geometric_error of the joint";
    parameters = {{.name = "offset",
                   .linear = spatial::dimension::length,
                   .angular = spatial::dimension::angle,
                   .lower = -0.5,
                   .upper = 0.5,
                   .prior_sd = 5e-4}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Eigen::Index k = modifier.chain().index_of(joint);
    if (modifier.chain().coordinates()[static_cast<std::size_t>(k)].role != Role::actuated)
      throw std::invalid_argument(fmt::format("joint '{}' of chain '{}' has no drive with a zero",
                                              joint, modifier.chain().name()));
    modifier.add_transmission_error({.coordinate = k, .cosine = input.values[0], .order = 0});
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    columns.add_transmission_error(0, columns.state().chain.index_of(joint), 1);
  }
};

}  // namespace

Kind joint_offset() { return std::make_shared<JointOffset>(); }

}  // namespace kinetostat::vjm::effects
