#include "kinetostat/vjm/chain/chain_modifier.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace kinetostat::vjm {

using Eigen::Index;
using spatial::Pose;

namespace {

// A spring stiffer than this many times the stiffest of its kind is lost in rounding.
constexpr double rigid = 1e9;

void move(Node& node, const Pose& change) {
  node.position = change * node.position;
  node.axes = change.rotation() * node.axes;
}

}  // namespace

void ChainModifier::take_back(const Chain& original) {
  if (!is_built_as_before_) chain_ = original;
  chain_.laws_.resize(original.laws().size());
  chain_.transmission_errors_.resize(original.transmission_errors().size());
  is_built_as_before_ = true;
}

void ChainModifier::add_law(const std::string& joint, std::shared_ptr<const CoordinateLaw> law) {
  chain_.laws_.emplace_back(chain_.index_of(joint), std::move(law));
}

void ChainModifier::scale_spring(const std::string& spring, double factor) {
  is_built_as_before_ = false;
  if (!(factor > 0) || !std::isfinite(factor))
    throw std::invalid_argument("the factor of a stiffness must be positive");
  for (Spring& s : chain_.springs_) {
    if (s.name != spring) continue;
    if (s.series > 0) {
      s.stiffness(0, 0) = 1 / ((1 / s.stiffness(0, 0) - s.series) / factor + s.series);
    } else {
      s.stiffness *= factor;
    }
    chain_.stiffness_.block(s.first, s.first, s.stiffness.rows(), s.stiffness.cols()) = s.stiffness;
    return;
  }
  throw std::invalid_argument(fmt::format("chain '{}' has no spring '{}'", chain_.name_, spring));
}

void ChainModifier::take_spring(const std::string& spring, const Chain& from) {
  is_built_as_before_ = false;
  const auto named = [&](const Spring& s) { return s.name == spring; };
  const auto own = std::find_if(chain_.springs_.begin(), chain_.springs_.end(), named);
  const auto other = std::find_if(from.springs().begin(), from.springs().end(), named);
  if (own == chain_.springs_.end() || other == from.springs().end())
    throw std::invalid_argument(fmt::format("chain '{}' has no spring '{}'", chain_.name_, spring));
  own->stiffness = other->stiffness;
  own->series = other->series;
  chain_.stiffness_.block(own->first, own->first, own->stiffness.rows(), own->stiffness.cols()) =
      own->stiffness;
}

void ChainModifier::add_series_compliance(const std::string& joint, double compliance) {
  is_built_as_before_ = false;
  const Index k = chain_.index_of(joint);
  for (Spring& spring : chain_.springs_) {
    if (spring.first != k || spring.stiffness.rows() != 1) continue;
    spring.stiffness(0, 0) /= 1 + spring.stiffness(0, 0) * compliance;
    spring.series += compliance;
    chain_.stiffness_(k, k) = spring.stiffness(0, 0);
    return;
  }
  throw std::invalid_argument(
      fmt::format("joint '{}' of chain '{}' has no spring", joint, chain_.name_));
}

// Zero: there are none.
double ChainModifier::stiffest(bool turns) const {
  double most = beside_[turns ? 1 : 0];
  for (Index k = 0; k < chain_.size(); ++k)
    if (is_rotation(chain_.coordinates_[static_cast<std::size_t>(k)].motion) == turns)
      most = std::max(most, chain_.stiffness_(k, k));
  return most;
}

void ChainModifier::add_compliance_behind(const std::string& element, const std::string& name,
                                          Motion motion, double compliance) {
  is_built_as_before_ = false;
  const Index joints = chain_.joints_to(element);
  if (chain_.has_coordinate(name)) return add_series_compliance(name, compliance);
  const double most = stiffest(is_rotation(motion));
  if (!(compliance > 0) || (most > 0 && compliance * most * rigid < 1)) return;
  const Index k = chain_.add_coordinate({name, Role::elastic, motion, 0});
  chain_.add_spring(name, k, Spring::Matrix::Constant(1, 1, 1 / compliance));
  chain_.springs_.back().series = compliance;
  chain_.free_.push_back(k);
  insert_joint(joints, motion, k);
}

// Behind the first `joints` joints. What stood in the frame there then stands behind the new joint.
void ChainModifier::insert_joint(Index joints, Motion motion, Index coordinate) {
  const Pose lead = joints == 0 ? chain_.base_ : Pose();
  const bool last = joints == static_cast<Index>(chain_.joints_.size());
  Pose& behind = last ? chain_.tail_ : chain_.joints_[static_cast<std::size_t>(joints)].before;
  Pose& nominal =
      last ? chain_.nominal_tail_ : chain_.joints_[static_cast<std::size_t>(joints)].nominal_before;
  behind = lead.inverse() * behind;
  nominal = lead.inverse() * nominal;
  if (!last) chain_.joints_[static_cast<std::size_t>(joints)].before_is_identity = false;
  chain_.joints_.insert(chain_.joints_.begin() + joints,
                        {lead, lead, false, motion, coordinate, 1});
  for (Node& node : chain_.nodes_) {
    if (node.joints == joints) move(node, lead.inverse());
    if (node.joints >= joints) ++node.joints;
  }
  for (ChainDisplacement& place : chain_.displacements_)
    if (place.joints >= joints) ++place.joints;
}

ChainDisplacement& ChainModifier::displacement_at(const std::string& element, bool in_front) {
  for (ChainDisplacement& place : chain_.displacements_)
    if (place.place == element && place.in_front == in_front) return place;
  const bool at_end = element == "end";
  chain_.displacements_.push_back(
      {.place = element,
       .in_front = in_front || at_end,
       .joints = in_front && !at_end ? chain_.first_joint_of(element) : chain_.joints_to(element)});
  return chain_.displacements_.back();
}

void ChainModifier::add_displacement(const std::string& element, bool in_front,
                                     const spatial::Vector6& displacement) {
  is_built_as_before_ = false;
  ChainDisplacement& place = displacement_at(element, in_front || element == "end");
  const Pose before = spatial::displaced(Pose(), place.value);
  place.value += displacement;
  move_place(place, spatial::displaced(Pose(), place.value) * before.inverse());
  chain_.has_errors_ = true;
}

// `change` multiplies the displacement of the place from the left.
void ChainModifier::move_place(const ChainDisplacement& place, const Pose& change) {
  const bool last = place.joints == static_cast<Index>(chain_.joints_.size());
  Pose& gap = last ? chain_.tail_ : chain_.joints_[static_cast<std::size_t>(place.joints)].before;
  if (!last) chain_.joints_[static_cast<std::size_t>(place.joints)].before_is_identity = false;
  const Pose after = spatial::displaced(Pose(), place.value);
  if (place.in_front) {
    // gap = rigid part, old displacement; of the end also what lies between it and the body.
    const Pose old = change.inverse() * after;
    const Pose beyond = last ? chain_.attachment_ : Pose();
    gap = gap * beyond.inverse() * old.inverse() * after * beyond;
    return;
  }
  const Pose lead = place.joints == 0 ? chain_.base_ : Pose();
  const Pose moved = lead * change * lead.inverse();
  gap = moved * gap;
  for (Node& node : chain_.nodes_)
    if (node.joints == place.joints) move(node, moved);
}

void ChainModifier::add_node(const std::string& name, const std::string& place, const Pose& pose) {
  is_built_as_before_ = false;
  const auto named = std::find_if(chain_.nodes_.begin(), chain_.nodes_.end(),
                                  [&place](const Node& node) { return node.name == place; });
  Node node{.name = name, .joints = 0, .position = pose.position(), .axes = pose.rotation()};
  if (named != chain_.nodes_.end()) {
    node.joints = named->joints;
    move(node, Pose(named->axes, named->position));
  } else if (place == "end") {
    chain_.add_node_at_end(name, pose.position());
    return;
  } else {
    node.joints = chain_.joints_to(place);
    if (node.joints == 0) move(node, chain_.base_);
  }
  chain_.add_node(node);
}

void ChainModifier::add_mass(const std::string& name, double mass, Index joints,
                             const spatial::Vector3& position) {
  is_built_as_before_ = false;
  chain_.add_node({name, joints, position});
  chain_.masses_.push_back({chain_.nodes_.size() - 1, mass});
}

void ChainModifier::add_transmission_error(const TransmissionError& shift) {
  const Coordinate& coordinate = chain_.coordinates_.at(static_cast<std::size_t>(shift.coordinate));
  const bool has_spring = chain_.stiffness_(shift.coordinate, shift.coordinate) != 0;
  if (coordinate.role != Role::actuated && !has_spring)
    throw std::invalid_argument(
        fmt::format("joint '{}' of chain '{}' has neither a drive nor a spring that could lead it "
                    "elsewhere",
                    coordinate.name, chain_.name_));
  chain_.transmission_errors_.push_back(shift);
}

void ChainModifier::add_mass_at_end(const std::string& name, double mass,
                                    const spatial::Vector3& position) {
  is_built_as_before_ = false;
  chain_.add_mass_at_end(name, mass, position, name);
}

}  // namespace kinetostat::vjm
