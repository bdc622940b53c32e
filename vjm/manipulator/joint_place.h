// Joints of a manipulator by their names.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// A coordinate of a chain that is a joint of it.
struct JointPlace {
  std::size_t chain = 0;
  Eigen::Index coordinate = 0;

  bool operator==(const JointPlace&) const = default;
};

/// The actuated or passive joint "chain.joint", or "joint" where the name is unique. Throws
/// std::invalid_argument for an unknown name (with did-you-mean) or an ambiguous one.
JointPlace find_joint(const Manipulator& manipulator, const std::string& name);

const Coordinate& coordinate_at(const Manipulator& manipulator, const JointPlace& place);
/// "chain.joint".
std::string full_name(const Manipulator& manipulator, const JointPlace& place);
/// In the order of the chains.
std::vector<JointPlace> actuated_joints(const Manipulator& manipulator);

}  // namespace kinetostat::vjm
