// What is watched of a manipulator beside its platform: frames that its parts carry, and joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::vjm {

/// A frame on the base, on a body, or at a place of a chain.
struct CarriedFrame {
  int body = -1;  // where it is not on a chain; Span::base, or its number
  std::optional<std::size_t> chain = {};
  std::string place = {};   // of the chain: a node; or "base", a joint or link: right behind it
  spatial::Pose pose = {};  // in the axes of the body, or of the frame at the place
  /// Seen by the instrument that effects at `sensor` are about.
  bool by_instrument = false;
};

/// A joint whose coordinate and drive are read.
struct WatchedJoint {
  std::size_t chain = 0;
  Eigen::Index coordinate = 0;
};

struct Watch {
  std::vector<CarriedFrame> frames = {};
  std::vector<WatchedJoint> joints = {};

  bool is_empty() const { return frames.empty() && joints.empty(); }
};

/// What is seen of a watch: poses of its frames, base axes; and of each joint its coordinate
/// [m or rad] and the force that its drive exerts, positive along the coordinate [N or N m].
struct Watched {
  std::vector<spatial::Pose> frames = {};
  Eigen::VectorXd joints = {};  // two a joint
  /// Derivatives by the parameters, and by the stated wrench: six rows a frame [translation;
  /// rotation increment], two a joint; one column a variable.
  Eigen::MatrixXd derivatives = {}, by_wrench = {};
};

}  // namespace kinetostat::vjm
