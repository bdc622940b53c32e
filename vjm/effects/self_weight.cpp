// A link that weighs more than the model knows.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/effects/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// Half of the mass of each segment moves with its start and half with its end, one sixth of the
// way from either: LinkModel::append_to says why.
struct Share {
  Eigen::Index joints;
  spatial::Vector3 position;
};

std::vector<Share> shares_of(const Chain& chain, const std::string& link) {
  std::vector<Share> shares;
  for (const Spring& spring : chain.springs()) {
    if (spring.stiffness.rows() != 6 ||
        (spring.name != link && !spring.name.starts_with(link + ".")))
      continue;
    const Eigen::Index first = chain.first_joint_of(spring.name);
    const spatial::Pose& part = chain.joints()[static_cast<std::size_t>(first)].nominal_before;
    shares.push_back({first, part.position() / 6});
    shares.push_back({first + 6, -(part.rotation().transpose() * part.position()) / 6});
  }
  if (shares.empty())
    throw std::invalid_argument(
        fmt::format("chain '{}' has no flexible link '{}'", chain.name(), link));
  return shares;
}

class SelfWeight : public EffectKind {
 public:
  SelfWeight() {
    name = "self_weight";
    summary = "a link is heavier than the model knows";
    law = "weight mass g, distributed over the link as over a uniform beam";
    source = "gravity distributed over links: two point masses per segment, docs/theory/gravity.md";
    signature =
        "sag along gravity that depends on the posture; invisible in differences, but for "
        "the change of stiffness";
    confuser = "payload";
    place = EffectPlace::link;
    parameters = {{.name = "mass",
                   .linear = spatial::dimension::mass,
                   .angular = spatial::dimension::mass,
                   .lower = 0,
                   .upper = 1e5,
                   .prior_sd = 10}};
  }

  void act(Chain& chain, const std::string& link, const EffectInput& input) const override {
    const std::vector<Share> shares = shares_of(chain, link);
    for (const Share& share : shares)
      chain.add_mass(free_node_name(chain, "weight of " + link),
                     input.values[0] / static_cast<double>(shares.size()), share.joints,
                     share.position);
  }

  void differentiate(ChainColumns& columns, const std::string& link,
                     const EffectInput&) const override {
    const ChainState& state = columns.state();
    const std::vector<Share> shares = shares_of(state.chain, link);
    spatial::Vector6 weight = spatial::Vector6::Zero();
    weight.head<3>() = state.gravity / static_cast<double>(shares.size());
    for (const Share& share : shares) {
      const spatial::Pose frame = frame_behind(state.chain, state.x, share.joints, state.origin);
      columns.add_wrench(0, {weight, frame * share.position, share.joints});
    }
  }
};

}  // namespace

Kind self_weight() { return std::make_shared<SelfWeight>(); }

}  // namespace kinetostat::vjm::effects
