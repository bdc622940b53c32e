// A link that is softer or stiffer than designed by one factor: its modulus, or its section.
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/effects/kinds.h"

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

Chain applied(const Chain& chain, const std::string& link, const Eigen::VectorXd& values) {
  Chain result = chain;
  for (const Spring* spring : springs_of_link(chain, link))
    result = result.with_scaled_spring(spring->name, 1 / values[0]);
  return result;
}

Eigen::MatrixXd force_derivatives(const EffectState& state, const std::string& link,
                                  const Eigen::VectorXd& values) {
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(state.chain.size(), 1);
  for (const Spring* spring : springs_of_link(state.chain, link))
    derivatives.col(0).segment(spring->first, 6) =
        spring->stiffness * state.deflection.segment(spring->first, 6) / values[0];
  return derivatives;
}

}  // namespace

EffectKind link_compliance() {
  return {.name = "link_compliance",
          .summary = "all compliances of a link times one factor",
          .law = "C = factor C0",
          .source =
              "JAMRIS09 eq. 1: the compliance of a link is inversely proportional to its "
              "modulus",
          .signature =
              "displacement in the pattern of the link's deflection, in proportion to the "
              "load",
          .confuser = "joint_compliance of the joint before the link",
          .place = EffectPlace::link,
          .parameters = {{.name = "factor",
                          .linear = spatial::dimension::none,
                          .angular = spatial::dimension::none,
                          .lower = 0.01,
                          .upper = 100,
                          .prior_sd = 0.3,
                          .none = 1}},
          .applied = applied,
          .force_derivatives = force_derivatives};
}

}  // namespace kinetostat::vjm::effects
