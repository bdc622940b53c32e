// The options that leave motions free along a path: turn, joints and placement.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/workspace/path_choice.h"

namespace kinetostat::apps {

/// --turn, --joint and --place with what belongs to them.
struct FreedomRequest {
  std::string turn, turn_range, turn_change, place;
  std::vector<std::string> joints, joint_ranges, joint_changes;

  bool is_asked_for() const { return !turn.empty() || !joints.empty() || !place.empty(); }
  /// The first of them that is.
  std::string given() const {
    return !turn.empty() ? "--turn" : !joints.empty() ? "--joint" : "--place";
  }
  void add_options(OptionList& app);
  /// For the poses of a path as they were given. Throws UsageError, also for a joint that no pose
  /// of them leaves free.
  vjm::PathFreedom read(const vjm::Robot& robot, const std::vector<vjm::TargetPose>& poses) const;
};

}  // namespace kinetostat::apps
