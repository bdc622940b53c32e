#include "kinetostat/vjm/chain.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "kinetostat/spatial/spelling.h"

namespace kinetostat::vjm {
namespace {

constexpr Motion all_motions[] = {Motion::tx, Motion::ty, Motion::tz,
                                  Motion::rx, Motion::ry, Motion::rz};

bool is_identity(const spatial::Pose& pose) {
  return pose.position().isZero(0) && pose.rotation() == spatial::Matrix3::Identity();
}

}  // namespace

std::string to_string(Motion motion) {
  static const char* names[] = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};
  return names[static_cast<int>(motion)];
}

Chain::Chain(std::string name, const spatial::Pose& base) : name_(std::move(name)), tail_(base) {}

Chain& Chain::offset(const spatial::Pose& pose) {
  tail_ = tail_ * pose;
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
  if (is_rotation(coordinate.motion) != is_rotation(motion))
    throw std::invalid_argument(fmt::format(
        "'{}' cannot drive a {} joint: one turns, the other slides", name, to_string(motion)));
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
  const std::string near = spatial::nearest_spelling(coordinate, names);
  throw std::invalid_argument(
      fmt::format("chain '{}' has no joint '{}'{}", name_, coordinate,
                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near)));
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
    s.stiffness *= factor;
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
  joints_.push_back({tail_, is_identity(tail_), motion, coordinate, factor});
  tail_ = {};
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
