#include "kinetostat/vjm/manipulator.h"

#include <set>
#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::vjm {

Manipulator::Manipulator(std::string name, std::vector<Chain> chains)
    : name_(std::move(name)), chains_(std::move(chains)) {
  if (chains_.empty()) throw std::invalid_argument("a manipulator needs at least one chain");
  std::set<std::string> names;
  for (const Chain& chain : chains_)
    if (!names.insert(chain.name()).second)
      throw std::invalid_argument(fmt::format("two chains are named '{}'", chain.name()));
}

Manipulator Manipulator::with_reference_point(const spatial::Vector3& point_on_platform) const {
  Manipulator copy = *this;
  for (Chain& chain : copy.chains_) chain.offset(spatial::Pose::translation(point_on_platform));
  return copy;
}

Manipulator Manipulator::with_chain(std::size_t index, Chain chain) const {
  Manipulator copy = *this;
  copy.chains_.at(index) = std::move(chain);
  return copy;
}

Eigen::VectorXd Posture::rest(const Chain& chain, std::size_t index) const {
  Eigen::VectorXd rest = chain.default_rest();
  for (Eigen::Index k = 0; k < chain.size(); ++k)
    if (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::actuated)
      rest[k] = coordinates[index][k];
  return rest;
}

}  // namespace kinetostat::vjm
