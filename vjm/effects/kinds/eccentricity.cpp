// A drive whose joint follows the command with a periodic error.
#include <cmath>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace eccentricity_kind {
namespace {

enum Value { cosine, sine, order };

class Eccentricity : public EffectKind {
 public:
  Eccentricity() {
    const auto amplitude = [](const char* called) {
      return EffectParameter{.name = called,
                             .linear = spatial::dimension::length,
                             .angular = spatial::dimension::angle,
                             .lower = -0.1,
                             .upper = 0.1,
                             .prior_sd = 0.1,
                             .prior_unit = PriorUnit::joint_play,
                             .required = false};
    };
    name = "eccentricity";
    effect_class = EffectClass::geometry;
    summary = "a drive with a periodic error: an eccentric gear, a screw with a drunken thread";
    law = "rest value = u + cosine cos(order u) + sine sin(order u) for the command u";
    source = "kinematic transmission error: ISO 1328-2; VDI/VDE 2608";
    signature = "an offset periodic in the joint's command, whatever the load";
    confuser = "geometric_error in front of the joint, at few postures";
    place = EffectPlace::joint;
    acts_on_joint_alone = true;
    parameters = {amplitude("cosine"), amplitude("sine"), order_of_ripple({1, 2, 3, 4})};
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    modifier.add_transmission_error({.coordinate = modifier.chain().index_of(joint),
                                     .cosine = input.values[cosine],
                                     .sine = input.values[sine],
                                     .order = input.values[order]});
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const Eigen::Index k = columns.state().chain.index_of(joint);
    const double command = columns.state().x[k] - columns.state().travel[k];
    const double c = std::cos(input.values[order] * command);
    const double s = std::sin(input.values[order] * command);
    columns.add_transmission_error(cosine, k, c);
    columns.add_transmission_error(sine, k, s);
    columns.add_transmission_error(order, k,
                                   command * (input.values[sine] * c - input.values[cosine] * s));
  }
};

}  // namespace
}  // namespace eccentricity_kind

Kind eccentricity() { return std::make_shared<eccentricity_kind::Eccentricity>(); }

}  // namespace kinetostat::vjm::effects
