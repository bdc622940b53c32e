// A mass on the platform that the model does not know of.
#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

class Payload : public EffectKind {
 public:
  Payload() {
    const auto coordinate = [](const char* axis) {
      return EffectParameter{.name = axis,
                             .linear = spatial::dimension::length,
                             .angular = spatial::dimension::length,
                             .lower = -10,
                             .upper = 10,
                             .prior_sd = 0.1,
                             .required = false,
                             .is_shape = true};
    };
    name = "payload";
    effect_class = EffectClass::weight;
    is_exact = true;
    summary = "a mass on the platform, with its centre in platform axes";
    law = "weight mass g at the point [x, y, z] of the platform";
    source = "dead weight; MMT11 eq. 5 with a load at a node";
    signature =
        "sag along gravity that depends on the posture; invisible in differences, but for the "
        "change of stiffness";
    confuser = "geometric_error, at few postures; self_weight of the last link";
    place = EffectPlace::platform;
    parameters = {{.name = "mass",
                   .linear = spatial::dimension::mass,
                   .angular = spatial::dimension::mass,
                   .lower = 0,
                   .upper = 1e5,
                   .prior_sd = 10},
                  coordinate("x"),
                  coordinate("y"),
                  coordinate("z")};
  }

  void act(ChainModifier& modifier, const std::string&, const EffectInput& input) const override {
    modifier.add_mass_at_end(free_node_name(modifier.chain(), "payload"), input.values[0],
                             center(input));
  }

  void differentiate(ChainColumns& columns, const std::string&,
                     const EffectInput& input) const override {
    const ChainState& state = columns.state();
    // Where mass() has put it: displacements of the end leave it alone.
    PlaceFrame platform = frame_of(state, "end", true);
    platform.pose = platform.pose * state.chain.attachment();
    const spatial::Vector3 point = platform.pose * center(input);
    const auto add = [&](Eigen::Index column, const spatial::Vector3& force,
                         const spatial::Vector3& moment) {
      spatial::Vector6 wrench;
      wrench << force, moment;
      columns.add_wrench(column, {wrench, point, platform.joints});
    };
    add(0, state.gravity, spatial::Vector3::Zero());
    // The weight moved aside is the same weight with a moment.
    for (Eigen::Index i = 0; i < 3; ++i)
      add(1 + i, spatial::Vector3::Zero(),
          platform.pose.rotation().col(i).cross(input.values[0] * state.gravity));
  }

 private:
  static spatial::Vector3 center(const EffectInput& input) { return input.values.segment<3>(1); }
};

}  // namespace

std::string free_node_name(const Chain& chain, std::string name) {
  const auto taken = [&] {
    for (const Node& node : chain.nodes())
      if (node.name == name) return true;
    return false;
  };
  while (taken()) name += "+";
  return name;
}

Kind payload() { return std::make_shared<Payload>(); }

}  // namespace kinetostat::vjm::effects
