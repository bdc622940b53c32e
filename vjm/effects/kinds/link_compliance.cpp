// A link that is softer or stiffer than nominal by one factor: its modulus, or its section.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// The springs of a link: one, or those of its segments.
std::vector<const Spring*> springs_of_link(const Chain& chain, const std::string& link) {
  std::vector<const Spring*> springs;
  for (const Spring& spring : chain.springs())
    if (spring.stiffness.rows() == 6 &&
        (spring.name == link || spring.name.starts_with(link + ".")))
      springs.push_back(&spring);
  if (springs.empty())
    throw std::invalid_argument(
        fmt::format("chain '{}' has no flexible link '{}'", chain.name(), link));
  return springs;
}

class LinkCompliance : public EffectKind {
 public:
  LinkCompliance() {
    name = "link_compliance";
    effect_class = EffectClass::compliance;
    summary = "all compliances of a link times one factor";
    law = "C = factor C0";
    source = "JAMRIS09 eq. 1: the compliance of a link is inversely proportional to its modulus";
    signature = "displacement in the pattern of the link's deflection, in proportion to the load";
    confuser =
        "platform_compliance or bearing_compliance beside it; joint_compliance of the joint before";
    place = EffectPlace::link;
    parameters = {{.name = "factor",
                   .linear = spatial::dimension::none,
                   .angular = spatial::dimension::none,
                   .lower = 0.01,
                   .upper = 100,
                   .prior_sd = 0.3,
                   .none = 1}};
  }

  void act(ChainModifier& modifier, const std::string& link,
           const EffectInput& input) const override {
    std::vector<std::string> names;
    for (const Spring* spring : springs_of_link(modifier.chain(), link))
      names.push_back(spring->name);
    for (const std::string& spring : names) modifier.scale_spring(spring, 1 / input.values[0]);
  }

  void differentiate(ChainColumns& columns, const std::string& link,
                     const EffectInput& input) const override {
    const ChainState& state = columns.state();
    for (const Spring* spring : springs_of_link(state.chain, link)) {
      const Eigen::VectorXd force =
          spring->stiffness * state.deflection.segment(spring->first, 6) / input.values[0];
      for (Eigen::Index i = 0; i < 6; ++i) columns.add_force(0, spring->first + i, force[i]);
    }
  }
};

}  // namespace

Kind link_compliance() { return std::make_shared<LinkCompliance>(); }

}  // namespace kinetostat::vjm::effects
