// Drives that move their joint by another amount than commanded, or by what another drive does.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

using Eigen::Index;

double home_of(const Chain& chain, Index coordinate) {
  return chain.coordinates()[static_cast<std::size_t>(coordinate)].home;
}

// The rest value of a joint changes by one number times how far a leading drive is from home.
class Ratio : public EffectKind {
 public:
  Ratio() {
    effect_class = EffectClass::geometry;
    place = EffectPlace::joint;
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const Chain& chain = modifier.chain();
    const Index k = chain.index_of(joint), leader = leader_of(chain, k);
    modifier.add_transmission_error({.coordinate = k,
                                     .leader = leader,
                                     .ratio = input.values[0],
                                     .from = home_of(chain, leader)});
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput&) const override {
    const ChainState& state = columns.state();
    const Index k = state.chain.index_of(joint), leader = leader_of(state.chain, k);
    const double command = state.x[leader] - state.travel[leader];
    columns.add_transmission_error(0, k, command - home_of(state.chain, leader));
  }

 protected:
  /// The coordinate that leads `k`. Throws std::invalid_argument where there is none.
  virtual Index leader_of(const Chain& chain, Index k) const = 0;
};

class TransmissionRatio : public Ratio {
 public:
  TransmissionRatio() {
    name = "transmission_ratio";
    summary = "a drive that moves its joint too far or not far enough, in one proportion";
    law = "rest value = u + ratio (u - home) for the command u";
    source = "mean bi-directional positional deviation growing along an axis: ISO 230-2";
    signature = "an offset in proportion to the joint's command, whatever the load";
    confuser = "thermal_expansion of a screw; eccentricity of a long period";
    least_commands = 3;  // an offset, the ratio, and one to see whether it is so
    parameters = {{.name = "ratio",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = -0.1,
                   .upper = 0.1,
                   .prior_sd = 3e-4}};
  }

 protected:
  Index leader_of(const Chain&, Index k) const override { return k; }
};

class JointCoupling : public Ratio {
 public:
  JointCoupling() {
    name = "joint_coupling";
    summary = "a joint that moves along when the drive before it does: gears of a wrist, belts";
    law = "rest value = u + ratio (v - home of v), v the command of the drive before it";
    source =
        "coupled wrist joints: Mooring, Roth and Driels, Fundamentals of Manipulator "
        "Calibration, Wiley 1991";
    signature = "an offset of one joint in proportion to the command of the drive before it";
    confuser = "geometric_error of the joint, at few postures; transmission_ratio of the other one";
    parameters = {{.name = "ratio",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = -1,
                   .upper = 1,
                   .prior_sd = 1e-3}};
  }

 protected:
  Index leader_of(const Chain& chain, Index k) const override {
    const auto& coordinates = chain.coordinates();
    const auto sort = [&](Index i) {
      return is_rotation(coordinates[static_cast<std::size_t>(i)].motion);
    };
    for (Index i = k - 1; i >= 0; --i)
      if (coordinates[static_cast<std::size_t>(i)].role == Role::actuated) {
        if (sort(i) == sort(k)) return i;
        break;
      }
    throw std::invalid_argument(
        fmt::format("joint '{}' of chain '{}' has no drive of its own sort before it that could "
                    "move it",
                    coordinates[static_cast<std::size_t>(k)].name, chain.name()));
  }
};

}  // namespace

Kind transmission_ratio() { return std::make_shared<TransmissionRatio>(); }
Kind joint_coupling() { return std::make_shared<JointCoupling>(); }

}  // namespace kinetostat::vjm::effects
