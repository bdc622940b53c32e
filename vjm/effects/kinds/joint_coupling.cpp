// A drive that moves the joint behind it, too.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

using Eigen::Index;

class JointCoupling : public EffectKind {
 public:
  JointCoupling() {
    name = "joint_coupling";
    effect_class = EffectClass::geometry;
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    summary = "a joint that turns along when the drive before it does: gears of a wrist, belts";
    law = "rest value = u + ratio (v - home of v), v the command of the drive before it";
    source =
        "coupled wrist joints: Mooring, Roth and Driels, Fundamentals of Manipulator "
        "Calibration, Wiley 1991";
    signature = "an offset of one joint in proportion to the command of the drive before it";
    confuser = "geometric_error of the joint, at few postures; eccentricity of the drive before it";
    parameters = {{.name = "ratio",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = -1,
                   .upper = 1,
                   .prior_sd = 1e-3}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Chain& chain = modifier.chain();
    const Index k = chain.index_of(joint);
    lead_by_ratio(modifier, k, leader_of(chain, k), input.values[0]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    const Chain& chain = columns.state().chain;
    const Index k = chain.index_of(joint);
    add_ratio(columns, 0, k, leader_of(chain, k));
  }

 private:
  // The drive before it. A slide that moves along with another one is not square to it, which is a
  // geometric error.
  static Index leader_of(const Chain& chain, Index k) {
    const auto& coordinates = chain.coordinates();
    const auto turns = [&](Index i) {
      return is_rotation(coordinates[static_cast<std::size_t>(i)].motion);
    };
    for (Index i = k - 1; turns(k) && i >= 0; --i)
      if (coordinates[static_cast<std::size_t>(i)].role == Role::actuated) {
        if (turns(i)) return i;
        break;
      }
    throw std::invalid_argument(
        fmt::format("joint '{}' of chain '{}' does not turn behind a drive that turns",
                    coordinates[static_cast<std::size_t>(k)].name, chain.name()));
  }
};

}  // namespace

Kind joint_coupling() { return std::make_shared<JointCoupling>(); }

}  // namespace kinetostat::vjm::effects
