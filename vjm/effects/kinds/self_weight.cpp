// A link that weighs more than the model knows.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

// A part of the mass, in the frame that the first `joints` joints lead to.
struct Share {
  Eigen::Index joints;
  spatial::Vector3 position;
  double part;
};

// What an element weighs in the model already: all of it becomes heavier alike.
std::vector<Share> shares_of_mass(const Chain& chain, const std::string& element) {
  std::vector<Share> shares;
  double sum = 0;
  for (const PointMass& mass : chain.masses()) {
    if (mass.element != element) continue;
    const Node& node = chain.nodes()[mass.node];
    shares.push_back({node.joints, node.position, mass.mass});
    sum += mass.mass;
  }
  if (!(sum > 0)) return {};
  for (Share& share : shares) share.part /= sum;
  return shares;
}

// A flexible link without a mass, as a uniform beam: half of each segment moves with its start and
// half with its end, one sixth of the way from either; LinkModel::append_to says why.
std::vector<Share> shares_of_beam(const Chain& chain, const std::string& link) {
  std::vector<Share> shares;
  for (const Spring& spring : chain.springs()) {
    if (spring.stiffness.rows() != 6 ||
        (spring.name != link && !spring.name.starts_with(link + ".")))
      continue;
    const Eigen::Index first = chain.first_joint_of(spring.name);
    const spatial::Pose& part = chain.joints()[static_cast<std::size_t>(first)].nominal_before;
    shares.push_back({first, part.position() / 6, 0});
    shares.push_back({first + 6, -(part.rotation().transpose() * part.position()) / 6, 0});
  }
  for (Share& share : shares) share.part = 1 / static_cast<double>(shares.size());
  return shares;
}

std::vector<Share> shares_of(const Chain& chain, const std::string& element) {
  std::vector<Share> shares = shares_of_mass(chain, element);
  if (shares.empty()) shares = shares_of_beam(chain, element);
  if (shares.empty())
    throw std::invalid_argument(fmt::format(
        "chain '{}' has nothing named '{}' that yields or has a mass", chain.name(), element));
  return shares;
}

class SelfWeight : public EffectKind {
 public:
  SelfWeight() {
    name = "self_weight";
    effect_class = EffectClass::weight;
    is_exact = true;
    summary = "a link is heavier than the model knows";
    law =
        "weight mass g, distributed as the mass that the link has in the model, else as over a "
        "uniform beam";
    source = "gravity distributed over links: two point masses per segment, docs/theory/gravity.md";
    signature =
        "sag along gravity that depends on the posture; invisible in differences, but for "
        "the change of stiffness";
    confuser = "payload";
    place = EffectPlace::mass;
    parameters = {{.name = "mass",
                   .linear = spatial::dimension::mass,
                   .angular = spatial::dimension::mass,
                   .lower = 0,
                   .upper = 1e5,
                   .prior_sd = 10}};
  }

  void act(ChainModifier& modifier, const std::string& link,
           const EffectInput& input) const override {
    const std::vector<Share> shares = shares_of(modifier.chain(), link);
    for (const Share& share : shares)
      modifier.add_mass(free_node_name(modifier.chain(), "weight of " + link),
                        share.part * input.values[0], share.joints, share.position);
  }

  void differentiate(ChainColumns& columns, const std::string& link,
                     const EffectInput&) const override {
    const ChainState& state = columns.state();
    const std::vector<Share> shares = shares_of(state.chain, link);
    for (const Share& share : shares) {
      spatial::Vector6 weight = spatial::Vector6::Zero();
      weight.head<3>() = share.part * state.gravity;
      const spatial::Pose frame = frame_behind(state.chain, state.x, share.joints, state.origin);
      columns.add_wrench(0, {weight, frame * share.position, share.joints});
    }
  }
};

}  // namespace

Kind self_weight() { return std::make_shared<SelfWeight>(); }

}  // namespace kinetostat::vjm::effects
