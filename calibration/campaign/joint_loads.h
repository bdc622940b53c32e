// What the loads of a campaign do to each joint, and whether its readings see it move.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"

namespace kinetostat::calibration {

/// An actuated joint with a spring, q the coordinate that its drive commands.
struct JointLoad {
  std::string name;    // as the table of readings calls it
  bool turns = false;  // else it slides
  /// Generalised forces of the loads, and in absolute poses of the weight, along the joint, least
  /// and largest over the readings in use: w' dX/dq with the wrench w and the motion dX/dq of the
  /// platform when the joint moves alone, passive joints following [N m, or N].
  double least = 0, largest = 0;
  /// Largest share of the load that drives the joint: |w' dX/dq| over what the same load could do,
  /// (|F| r + |M|) for a joint that turns, with r the distance of the point of application from the
  /// base, and |F| for one that slides.
  double share = 0;
  std::size_t postures = 0;  // in which a load drives it
  bool is_seen = false;      // some reading measures a component in which it moves the target then

  /// A share below this is a load that passes by: its direction is not known better.
  static constexpr double least_share = 0.01;
  bool is_loaded() const { return share > least_share; }
  bool is_observable() const { return is_loaded() && is_seen; }
};

/// In the order of the chains. Postures that cannot be reached count for nothing.
std::vector<JointLoad> joint_loads(const Campaign& campaign, const vjm::Manipulator& manipulator);

}  // namespace kinetostat::calibration
