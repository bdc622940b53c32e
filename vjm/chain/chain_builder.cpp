#include "kinetostat/vjm/chain/chain_builder.h"

#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::vjm {

ChainBuilder::ChainBuilder(std::string name, const spatial::Pose& base)
    : chain_(std::move(name), base) {}

ChainBuilder::ChainBuilder(Chain chain) : chain_(std::move(chain)) {}

ChainBuilder& ChainBuilder::offset(const spatial::Pose& pose) {
  chain_.tail_ = chain_.tail_ * pose;
  chain_.nominal_tail_ = chain_.nominal_tail_ * pose;
  return *this;
}

ChainBuilder& ChainBuilder::error(const spatial::Pose& pose) {
  chain_.tail_ = chain_.tail_ * pose;
  chain_.has_errors_ = true;
  return *this;
}

ChainBuilder& ChainBuilder::law(const std::string& name, std::shared_ptr<const CoordinateLaw> law) {
  chain_.laws_.emplace_back(chain_.index_of(name), std::move(law));
  return *this;
}

ChainBuilder& ChainBuilder::node(const std::string& name, const spatial::Vector3& position) {
  chain_.add_node_at_end(name, position);
  return *this;
}

ChainBuilder& ChainBuilder::attach(const spatial::Pose& to_reference) {
  chain_.attachment_ = chain_.attachment_ * to_reference;
  return offset(to_reference);
}

ChainBuilder& ChainBuilder::mass(const std::string& name, double mass,
                                 const spatial::Vector3& position, const std::string& element,
                                 const spatial::Matrix3& inertia) {
  chain_.add_mass_at_end(name, mass, position, element.empty() ? name : element, inertia);
  return *this;
}

ChainBuilder& ChainBuilder::actuator(const std::string& name, Motion motion,
                                     std::optional<double> stiffness, double home) {
  const Eigen::Index k = chain_.add_coordinate({name, Role::actuated, motion, home});
  chain_.add_joint(motion, k, 1);
  if (stiffness) chain_.add_spring(name, k, Spring::Matrix::Constant(1, 1, *stiffness));
  if (stiffness) chain_.free_.push_back(k);
  chain_.posture_.push_back(k);
  return *this;
}

ChainBuilder& ChainBuilder::range(const std::string& name, double least, double largest) {
  for (Coordinate& c : chain_.coordinates_) {
    if (c.name != name || c.role != Role::actuated) continue;
    if (!(least < largest))
      throw std::invalid_argument(
          fmt::format("the range of '{}' goes from {:g} to {:g}: the first must be less", name,
                      least, largest));
    c.range = {least, largest};
    return *this;
  }
  throw std::invalid_argument(fmt::format("there is no actuated joint '{}'", name));
}

ChainBuilder& ChainBuilder::passive(const std::string& name, Motion motion, double home) {
  const Eigen::Index k = chain_.add_coordinate({name, Role::passive, motion, home});
  chain_.add_joint(motion, k, 1);
  chain_.free_.push_back(k);
  chain_.posture_.push_back(k);
  return *this;
}

ChainBuilder& ChainBuilder::passive(const std::string& name, Motion motion, double stiffness,
                                    double rest, double home) {
  passive(name, motion, home);
  chain_.add_spring(name, chain_.size() - 1, Spring::Matrix::Constant(1, 1, stiffness));
  chain_.rest_[chain_.size() - 1] = rest;
  return *this;
}

ChainBuilder& ChainBuilder::coupled(const std::string& name, Motion motion, double factor) {
  const Eigen::Index k = chain_.index_of(name);
  const Coordinate& coordinate = chain_.coordinates_[static_cast<std::size_t>(k)];
  if (coordinate.role == Role::elastic)
    throw std::invalid_argument(fmt::format("'{}' is a virtual spring, not a joint", name));
  chain_.add_joint(motion, k, factor);
  return *this;
}

ChainBuilder& ChainBuilder::link(const std::string& name, const spatial::Pose& offset_to_end,
                                 const spatial::Compliance6& compliance) {
  const Eigen::Index first = chain_.size();
  elastic(name, offset_to_end);
  chain_.add_spring(name, first, compliance.inverse().matrix());
  return *this;
}

ChainBuilder& ChainBuilder::elastic(const std::string& name, const spatial::Pose& offset_to_end) {
  offset(offset_to_end);
  for (const Motion motion : all_motions) {
    const Eigen::Index k =
        chain_.add_coordinate({name + "." + to_string(motion), Role::elastic, motion, 0});
    chain_.add_joint(motion, k, 1);
    chain_.free_.push_back(k);
  }
  return *this;
}

}  // namespace kinetostat::vjm
