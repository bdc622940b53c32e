#include "kinetostat/vjm/chain/chain.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "kinetostat/common/spelling.h"

namespace kinetostat::vjm {
namespace {

bool is_identity(const spatial::Pose& pose) {
  return pose.position().isZero(0) && pose.rotation() == spatial::Matrix3::Identity();
}

}  // namespace

std::string to_string(Motion motion) {
  static const char* names[] = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};
  return names[static_cast<int>(motion)];
}

StopLaw::StopLaw(double lower, double upper, double stiffness)
    : lower_(lower), upper_(upper), stiffness_(stiffness) {
  if (!(lower < upper)) throw std::invalid_argument("the lower stop must be below the upper one");
  if (!(stiffness > 0)) throw std::invalid_argument("the stiffness of a stop must be positive");
}

CoordinateLaw::Value StopLaw::at(const JointState& joint) const {
  const double x = joint.position;
  const double beyond = x > upper_ ? x - upper_ : x < lower_ ? x - lower_ : 0.0;
  return {.energy = 0.5 * stiffness_ * beyond * beyond,
          .force = stiffness_ * beyond,
          .tangent = beyond != 0 ? stiffness_ : 0};
}

double StopLaw::middle() const {
  if (std::isinf(lower_)) return std::isinf(upper_) ? 0 : upper_;
  return std::isinf(upper_) ? lower_ : (lower_ + upper_) / 2;
}

Chain::Chain(std::string name, const spatial::Pose& base)
    : name_(std::move(name)), base_(base), tail_(base), nominal_tail_(base) {}

Chain& Chain::offset(const spatial::Pose& pose) {
  tail_ = tail_ * pose;
  nominal_tail_ = nominal_tail_ * pose;
  return *this;
}

Chain& Chain::error(const spatial::Pose& pose) {
  tail_ = tail_ * pose;
  has_errors_ = true;
  return *this;
}

Chain& Chain::law(const std::string& name, std::shared_ptr<const CoordinateLaw> law) {
  laws_.emplace_back(index_of(name), std::move(law));
  return *this;
}

Chain& Chain::node(const std::string& name, const spatial::Vector3& position) {
  for (const Node& other : nodes_)
    if (other.name == name)
      throw std::invalid_argument(fmt::format("chain '{}' has two nodes named '{}'", name_, name));
  // Displacements of the end are those of the tool point, not of what is mounted beside it.
  spatial::Pose tail = tail_ * attachment_.inverse();
  for (const ChainDisplacement& place : displacements_)
    if (place.place == "end") tail = tail * spatial::displaced({}, place.value).inverse();
  tail = tail * attachment_;
  add_node({name, static_cast<Eigen::Index>(joints_.size()), tail * position});
  return *this;
}

Chain& Chain::attach(const spatial::Pose& to_reference) {
  attachment_ = attachment_ * to_reference;
  return offset(to_reference);
}

Chain& Chain::mass(const std::string& name, double mass, const spatial::Vector3& position,
                   const std::string& element) {
  if (!(mass >= 0) || !std::isfinite(mass))
    throw std::invalid_argument(fmt::format("the mass of '{}' must not be negative", name));
  node(name, position);
  masses_.push_back({nodes_.size() - 1, mass, element.empty() ? name : element});
  return *this;
}

Chain& Chain::actuator(const std::string& name, Motion motion, std::optional<double> stiffness,
                       double home) {
  const Eigen::Index k = add_coordinate({name, Role::actuated, motion, home});
  add_joint(motion, k, 1);
  if (stiffness) add_spring(name, k, Spring::Matrix::Constant(1, 1, *stiffness));
  if (stiffness) free_.push_back(k);
  posture_.push_back(k);
  return *this;
}

Chain& Chain::range(const std::string& name, double least, double largest) {
  for (Coordinate& c : coordinates_) {
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

Chain& Chain::passive(const std::string& name, Motion motion, double home) {
  const Eigen::Index k = add_coordinate({name, Role::passive, motion, home});
  add_joint(motion, k, 1);
  free_.push_back(k);
  posture_.push_back(k);
  return *this;
}

Chain& Chain::passive(const std::string& name, Motion motion, double stiffness, double rest,
                      double home) {
  passive(name, motion, home);
  add_spring(name, size() - 1, Spring::Matrix::Constant(1, 1, stiffness));
  rest_[size() - 1] = rest;
  return *this;
}

Chain& Chain::coupled(const std::string& name, Motion motion, double factor) {
  const Eigen::Index k = index_of(name);
  const Coordinate& coordinate = coordinates_[static_cast<std::size_t>(k)];
  if (coordinate.role == Role::elastic)
    throw std::invalid_argument(fmt::format("'{}' is a virtual spring, not a joint", name));
  add_joint(motion, k, factor);
  return *this;
}

Chain& Chain::link(const std::string& name, const spatial::Pose& offset_to_end,
                   const spatial::Compliance6& compliance) {
  offset(offset_to_end);
  const Eigen::Index first = size();
  for (const Motion motion : all_motions) {
    const Eigen::Index k =
        add_coordinate({name + "." + to_string(motion), Role::elastic, motion, 0});
    add_joint(motion, k, 1);
    free_.push_back(k);
  }
  add_spring(name, first, compliance.inverse().matrix());
  return *this;
}

Eigen::Index Chain::index_of(const std::string& coordinate) const {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < coordinates_.size(); ++k) {
    if (coordinates_[k].name == coordinate) return static_cast<Eigen::Index>(k);
    names.push_back(coordinates_[k].name);
  }
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

Chain Chain::with_scaled_spring(const std::string& spring, double factor) const {
  if (!(factor > 0) || !std::isfinite(factor))
    throw std::invalid_argument("the factor of a stiffness must be positive");
  Chain copy = *this;
  for (Spring& s : copy.springs_) {
    if (s.name != spring) continue;
    if (s.series > 0) {
      s.stiffness(0, 0) = 1 / ((1 / s.stiffness(0, 0) - s.series) / factor + s.series);
    } else {
      s.stiffness *= factor;
    }
    copy.stiffness_.block(s.first, s.first, s.stiffness.rows(), s.stiffness.cols()) = s.stiffness;
    return copy;
  }
  throw std::invalid_argument(fmt::format("chain '{}' has no spring '{}'", name_, spring));
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

}  // namespace kinetostat::vjm
