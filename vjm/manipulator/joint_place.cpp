#include "kinetostat/vjm/manipulator/joint_place.h"

#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/spelling.h"

namespace kinetostat::vjm {
namespace {

[[noreturn]] void refuse_unknown(const Manipulator& manipulator, const std::string& name) {
  std::vector<std::string> known;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    for (const Eigen::Index k : manipulator.chains()[c].posture_coordinates()) {
      known.push_back(full_name(manipulator, {c, k}));
      if (manipulator.size() == 1) known.push_back(coordinate_at(manipulator, {c, k}).name);
    }
  const std::string near = common::nearest_spelling(name, known);
  throw std::invalid_argument(fmt::format("there is no joint '{}'{}", name,
                                          near.empty() ? "" : " (did you mean '" + near + "'?)"));
}

}  // namespace

JointPlace find_joint(const Manipulator& manipulator, const std::string& name) {
  std::vector<JointPlace> found;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    for (const Eigen::Index k : manipulator.chains()[c].posture_coordinates())
      if (name == coordinate_at(manipulator, {c, k}).name || name == full_name(manipulator, {c, k}))
        found.push_back({c, k});
  if (found.empty()) refuse_unknown(manipulator, name);
  if (found.size() > 1)
    throw std::invalid_argument(
        fmt::format("the joint '{}' is in several chains: write <chain>.{}", name, name));
  return found[0];
}

const Coordinate& coordinate_at(const Manipulator& manipulator, const JointPlace& place) {
  return manipulator.chains()[place.chain]
      .coordinates()[static_cast<std::size_t>(place.coordinate)];
}

std::string full_name(const Manipulator& manipulator, const JointPlace& place) {
  return manipulator.chains()[place.chain].name() + "." + coordinate_at(manipulator, place).name;
}

std::vector<JointPlace> actuated_joints(const Manipulator& manipulator) {
  std::vector<JointPlace> joints;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    for (Eigen::Index k = 0; k < manipulator.chains()[c].size(); ++k)
      if (coordinate_at(manipulator, {c, k}).role == Role::actuated) joints.push_back({c, k});
  return joints;
}

}  // namespace kinetostat::vjm
