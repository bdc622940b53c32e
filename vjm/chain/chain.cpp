#include "kinetostat/vjm/chain/chain.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "kinetostat/common/spelling.h"

namespace kinetostat::vjm {

using Eigen::Index;

namespace {

bool is_identity(const spatial::Pose& pose) {
  return pose.position().isZero(0) && pose.rotation() == spatial::Matrix3::Identity();
}

bool is_segment_of(const std::string& spring, const std::string& link) {
  return spring == link || spring.starts_with(link + ".");
}

}  // namespace

double TransmissionError::at(const Eigen::VectorXd& commands) const {
  const double u = commands[coordinate];
  return shift + cosine * std::cos(order * u) + sine * std::sin(order * u) +
         ratio * (commands[leader] - from);
}

Chain::Chain(std::string name, const spatial::Pose& base)
    : name_(std::move(name)), base_(base), tail_(base), nominal_tail_(base) {}

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
  Eigen::VectorXd rest;
  find_rest(commands, rest);
  return rest;
}

void Chain::find_rest(const Eigen::VectorXd& commands, Eigen::VectorXd& rest) const {
  rest = commands;
  for (const TransmissionError& shift : transmission_errors_)
    rest[shift.coordinate] += shift.at(commands);
}

Eigen::Index Chain::index_of(const std::string& coordinate) const {
  for (std::size_t k = 0; k < coordinates_.size(); ++k)
    if (coordinates_[k].name == coordinate) return static_cast<Eigen::Index>(k);
  std::vector<std::string> names;
  for (const Coordinate& other : coordinates_) names.push_back(other.name);
  const std::string near = common::nearest_spelling(coordinate, names);
  throw std::invalid_argument(
      fmt::format("chain '{}' has no joint '{}'{}", name_, coordinate,
                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

std::size_t Chain::node_index(const std::string& node) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].name == node) return i;
    names.push_back(nodes_[i].name);
  }
  const std::string near = common::nearest_spelling(node, names);
  throw std::invalid_argument(
      fmt::format("chain '{}' has no node '{}'{}", name_, node,
                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
}

Chain Chain::without_errors() const {
  Chain nominal = *this;
  for (Joint& joint : nominal.joints_) {
    joint.before = joint.nominal_before;
    joint.before_is_identity = is_identity(joint.before);
  }
  nominal.tail_ = nominal_tail_;
  nominal.has_errors_ = false;
  return nominal;
}

bool Chain::has_coordinate(const std::string& name) const {
  for (const Coordinate& coordinate : coordinates_)
    if (coordinate.name == name) return true;
  return false;
}

Eigen::VectorXd Chain::home() const {
  Eigen::VectorXd x(size());
  for (Eigen::Index k = 0; k < size(); ++k) x[k] = coordinates_[static_cast<std::size_t>(k)].home;
  return x;
}

Eigen::Index Chain::add_coordinate(const Coordinate& coordinate) {
  for (const Coordinate& other : coordinates_)
    if (other.name == coordinate.name)
      throw std::invalid_argument(
          fmt::format("chain '{}' has two joints or links named '{}'", name_, coordinate.name));
  coordinates_.push_back(coordinate);
  const Eigen::Index n = size();
  stiffness_.conservativeResizeLike(Eigen::MatrixXd::Zero(n, n));
  rest_.conservativeResizeLike(Eigen::VectorXd::Zero(n));
  return n - 1;
}

void Chain::add_joint(Motion motion, Eigen::Index coordinate, double factor) {
  joints_.push_back({tail_, nominal_tail_, is_identity(tail_), motion, coordinate, factor});
  tail_ = nominal_tail_ = {};
}

void Chain::add_spring(const std::string& name, Eigen::Index first,
                       const Spring::Matrix& stiffness) {
  if (!stiffness.allFinite() || Eigen::LLT<Spring::Matrix>(stiffness).info() != Eigen::Success)
    throw std::invalid_argument(
        fmt::format("the stiffness of '{}' in chain '{}' is not positive", name, name_));
  springs_.push_back({name, first, 0.5 * (stiffness + stiffness.transpose())});
  stiffness_.block(first, first, stiffness.rows(), stiffness.cols()) = springs_.back().stiffness;
}

// Among those of as many joints the newest last.
void Chain::add_node(const Node& node) {
  const auto behind = std::upper_bound(
      nodes_by_joints_.begin(), nodes_by_joints_.end(), node.joints,
      [this](Index joints, std::size_t other) { return joints < nodes_[other].joints; });
  nodes_by_joints_.insert(behind, nodes_.size());
  nodes_.push_back(node);
}

void Chain::add_node_at_end(const std::string& name, const spatial::Vector3& position) {
  for (const Node& other : nodes_)
    if (other.name == name)
      throw std::invalid_argument(fmt::format("chain '{}' has two nodes named '{}'", name_, name));
  // Displacements of the end are those of the tool point, not of what is mounted beside it.
  spatial::Pose tail = tail_ * attachment_.inverse();
  for (const ChainDisplacement& place : displacements_)
    if (place.place == "end") tail = tail * spatial::displaced({}, place.value).inverse();
  tail = tail * attachment_;
  add_node({name, static_cast<Eigen::Index>(joints_.size()), tail * position});
}

void Chain::add_mass_at_end(const std::string& name, double mass, const spatial::Vector3& position,
                            const std::string& element, const spatial::Matrix3& inertia) {
  if (!(mass >= 0) || !std::isfinite(mass))
    throw std::invalid_argument(fmt::format("the mass of '{}' must not be negative", name));
  add_node_at_end(name, position);
  const spatial::Matrix3 axes = tail_.rotation();
  masses_.push_back({nodes_.size() - 1, mass, element, axes * inertia * axes.transpose()});
}

}  // namespace kinetostat::vjm
