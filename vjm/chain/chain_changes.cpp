// What effects change in a chain that is built: further compliances, displacements, rest shifts.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/spelling.h"
#include "kinetostat/vjm/chain/chain.h"

namespace kinetostat::vjm {

using Eigen::Index;
using spatial::Pose;

namespace {

// A spring stiffer than this many times the stiffest of its kind is lost in rounding.
constexpr double rigid = 1e9;

bool is_segment_of(const std::string& spring, const std::string& link) {
  return spring == link || spring.starts_with(link + ".");
}

}  // namespace

double TransmissionError::at(double command) const {
  return shift + cosine * std::cos(order * command) + sine * std::sin(order * command);
}

Index Chain::joints_to(const std::string& element) const {
  if (element == "base") return 0;
  if (element == "end") return static_cast<Index>(joints_.size());
  Index last = -1;
  const auto take = [&](Index coordinate) {
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (joints_[j].coordinate == coordinate) last = std::max(last, static_cast<Index>(j));
  };
  for (const Spring& spring : springs_)
    if (spring.stiffness.rows() == 6 && is_segment_of(spring.name, element)) take(spring.first + 5);
  if (last < 0) take(index_of(element));
  return last + 1;
}

Index Chain::first_joint_of(const std::string& element) const {
  const auto joint_of = [this](Index coordinate) {
    const auto found =
        std::find_if(joints_.begin(), joints_.end(),
                     [coordinate](const Joint& joint) { return joint.coordinate == coordinate; });
    return static_cast<Index>(found - joints_.begin());
  };
  for (const Spring& spring : springs_)
    if (spring.stiffness.rows() == 6 && is_segment_of(spring.name, element))
      return joint_of(spring.first);
  return joint_of(index_of(element));
}

Eigen::VectorXd Chain::rest_for(const Eigen::VectorXd& commands) const {
  Eigen::VectorXd rest = commands;
  for (const TransmissionError& shift : transmission_errors_)
    rest[shift.coordinate] += shift.at(commands[shift.coordinate]);
  return rest;
}

Chain& Chain::add_series_compliance(const std::string& joint, double compliance) {
  const Index k = index_of(joint);
  for (Spring& spring : springs_) {
    if (spring.first != k || spring.stiffness.rows() != 1) continue;
    spring.stiffness(0, 0) /= 1 + spring.stiffness(0, 0) * compliance;
    spring.series += compliance;
    stiffness_(k, k) = spring.stiffness(0, 0);
    return *this;
  }
  throw std::invalid_argument(fmt::format("joint '{}' of chain '{}' has no spring", joint, name_));
}

Chain& Chain::add_compliance_behind(const std::string& element, const std::string& name,
                                    Motion motion, double compliance) {
  const Index joints = joints_to(element);
  if (has_coordinate(name)) return add_series_compliance(name, compliance);
  double stiffest = 0;
  for (Index k = 0; k < size(); ++k)
    if (is_rotation(coordinates_[static_cast<std::size_t>(k)].motion) == is_rotation(motion))
      stiffest = std::max(stiffest, stiffness_(k, k));
  if (!(compliance > 0) || (stiffest > 0 && compliance * stiffest * rigid < 1)) return *this;
  const Index k = add_coordinate({name, Role::elastic, motion, 0});
  add_spring(name, k, Spring::Matrix::Constant(1, 1, 1 / compliance));
  springs_.back().series = compliance;
  free_.push_back(k);
  insert_joint(joints, motion, k);
  return *this;
}

// Behind the first `joints` joints. What stood in the frame there then stands behind the new joint.
void Chain::insert_joint(Index joints, Motion motion, Index coordinate) {
  const Pose lead = joints == 0 ? base_ : Pose();
  const bool last = joints == static_cast<Index>(joints_.size());
  Pose& behind = last ? tail_ : joints_[static_cast<std::size_t>(joints)].before;
  Pose& nominal = last ? nominal_tail_ : joints_[static_cast<std::size_t>(joints)].nominal_before;
  behind = lead.inverse() * behind;
  nominal = lead.inverse() * nominal;
  if (!last) joints_[static_cast<std::size_t>(joints)].before_is_identity = false;
  joints_.insert(joints_.begin() + joints, {lead, lead, false, motion, coordinate, 1});
  for (Node& node : nodes_) {
    if (node.joints == joints) node.position = lead.inverse() * node.position;
    if (node.joints >= joints) ++node.joints;
  }
  for (ChainDisplacement& place : displacements_)
    if (place.joints >= joints) ++place.joints;
}

ChainDisplacement& Chain::displacement_at(const std::string& element, bool in_front) {
  for (ChainDisplacement& place : displacements_)
    if (place.place == element && place.in_front == in_front) return place;
  const bool at_end = element == "end";
  displacements_.push_back(
      {.place = element,
       .in_front = in_front || at_end,
       .joints = in_front && !at_end ? first_joint_of(element) : joints_to(element)});
  return displacements_.back();
}

Chain& Chain::add_displacement(const std::string& element, bool in_front,
                               const spatial::Vector6& displacement) {
  ChainDisplacement& place = displacement_at(element, in_front || element == "end");
  const Pose before = spatial::displaced(Pose(), place.value);
  place.value += displacement;
  move_place(place, spatial::displaced(Pose(), place.value) * before.inverse());
  has_errors_ = true;
  return *this;
}

// `change` multiplies the displacement of the place from the left.
void Chain::move_place(const ChainDisplacement& place, const Pose& change) {
  const bool last = place.joints == static_cast<Index>(joints_.size());
  Pose& gap = last ? tail_ : joints_[static_cast<std::size_t>(place.joints)].before;
  if (!last) joints_[static_cast<std::size_t>(place.joints)].before_is_identity = false;
  const Pose after = spatial::displaced(Pose(), place.value);
  if (place.in_front) {
    // gap = rigid part, old displacement; of the end also what lies between it and the body.
    const Pose old = change.inverse() * after;
    const Pose beyond = last ? attachment_ : Pose();
    gap = gap * beyond.inverse() * old.inverse() * after * beyond;
    return;
  }
  const Pose lead = place.joints == 0 ? base_ : Pose();
  const Pose moved = lead * change * lead.inverse();
  gap = moved * gap;
  for (Node& node : nodes_)
    if (node.joints == place.joints) node.position = moved * node.position;
}

// Among those of as many joints the newest last.
void Chain::add_node(const Node& node) {
  const auto behind = std::upper_bound(
      nodes_by_joints_.begin(), nodes_by_joints_.end(), node.joints,
      [this](Index joints, std::size_t other) { return joints < nodes_[other].joints; });
  nodes_by_joints_.insert(behind, nodes_.size());
  nodes_.push_back(node);
}

Chain& Chain::add_mass(const std::string& name, double mass, Index joints,
                       const spatial::Vector3& position) {
  add_node({name, joints, position});
  masses_.push_back({nodes_.size() - 1, mass});
  return *this;
}

Chain& Chain::add_transmission_error(const TransmissionError& shift) {
  const Coordinate& coordinate = coordinates_.at(static_cast<std::size_t>(shift.coordinate));
  const bool has_spring = stiffness_(shift.coordinate, shift.coordinate) != 0;
  if (coordinate.role != Role::actuated && !has_spring)
    throw std::invalid_argument(
        fmt::format("joint '{}' of chain '{}' has neither a drive nor a spring that could lead it "
                    "elsewhere",
                    coordinate.name, name_));
  transmission_errors_.push_back(shift);
  return *this;
}

}  // namespace kinetostat::vjm
