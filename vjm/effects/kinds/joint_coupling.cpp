// A drive that moves the joint behind it, too.
#include <cmath>
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
    summary = "a joint that turns along when a drive before it does: gears of a wrist, belts";
    law =
        "rest value = u + ratio (v - home of v), v the command of the drive before it that turns, "
        "or of the one before that with drives_back = 2";
    source =
        "coupled wrist joints: Mooring, Roth and Driels, Fundamentals of Manipulator "
        "Calibration, Wiley 1991";
    signature = "an offset of one joint in proportion to the command of a drive before it";
    confuser = "geometric_error of the joint, at few postures; eccentricity of the drive before it";
    parameters = {{.name = "ratio",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = -1,
                   .upper = 1,
                   .prior_sd = 1e-3},
                  {.name = "drives_back",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = 1,
                   .upper = 10,
                   .prior_sd = 1,
                   .none = 1,
                   .required = false,
                   .is_shape = true,
                   .usual_linear = {1, 2},
                   .usual_angular = {1, 2}}};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Chain& chain = modifier.chain();
    const Index k = chain.index_of(joint);
    lead_by_ratio(modifier, k, leader_of(chain, k, input.values[drives_back]), input.values[0]);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const Chain& chain = columns.state().chain;
    const Index k = chain.index_of(joint);
    add_ratio(columns, 0, k, leader_of(chain, k, input.values[drives_back]));
  }

 private:
  enum Value { ratio, drives_back };

  // The drive that many drives before it, of those that turn. A slide that moves along with another
  // one is not square to it, which is a geometric error.
  static Index leader_of(const Chain& chain, Index k, double back) {
    const auto& coordinates = chain.coordinates();
    const auto turns = [&](Index i) {
      return is_rotation(coordinates[static_cast<std::size_t>(i)].motion);
    };
    if (back != std::round(back))
      throw std::invalid_argument(
          "'drives_back' counts drives that turn: 1, the one before the joint, 2, ...");
    double passed = 0;
    for (Index i = k - 1; turns(k) && i >= 0; --i) {
      const bool is_drive = coordinates[static_cast<std::size_t>(i)].role == Role::actuated;
      if (is_drive && turns(i) && ++passed == back) return i;
    }
    throw std::invalid_argument(
        fmt::format("joint '{}' of chain '{}' does not turn behind {} that turns",
                    coordinates[static_cast<std::size_t>(k)].name, chain.name(),
                    back == 1 ? "a drive" : fmt::format("a drive {:.0f} drives back", back)));
  }
};

}  // namespace

Kind joint_coupling() { return std::make_shared<JointCoupling>(); }

}  // namespace kinetostat::vjm::effects
