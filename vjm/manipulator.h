// Serial and parallel manipulators: chains from one base that meet in one rigid platform.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/chain.h"

namespace kinetostat::vjm {

/// Constant description. Every chain runs from the base frame to the platform frame, whose origin
/// is the manipulator's reference point (tool point): a chain that ends elsewhere on the platform
/// is extended by a rigid link (IROS11 section IV), so that stiffness and wrenches simply add.
class Manipulator {
 public:
  /// Throws std::invalid_argument without chains, or with two of the same name.
  Manipulator(std::string name, std::vector<Chain> chains);

  const std::string& name() const { return name_; }
  const std::vector<Chain>& chains() const { return chains_; }
  std::size_t size() const { return chains_.size(); }

  /// The same manipulator with its reference point elsewhere on the platform (in platform axes).
  Manipulator with_reference_point(const spatial::Vector3& point_on_platform) const;
  /// The same manipulator with one chain exchanged.
  Manipulator with_chain(std::size_t index, Chain chain) const;

 private:
  std::string name_;
  std::vector<Chain> chains_;
};

/// Where a manipulator stands with all springs relaxed: coordinates of every chain (the values of
/// actuated joints are their commands), all of which lead to the same platform pose.
struct Posture {
  spatial::Pose platform;                    // in base axes
  std::vector<Eigen::VectorXd> coordinates;  // one per chain; 0 for virtual springs

  /// Rest values of the springs of a chain in this posture: commands where actuated.
  Eigen::VectorXd rest(const Chain& chain, std::size_t index) const;
};

}  // namespace kinetostat::vjm
