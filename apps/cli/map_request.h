// The options of a map: its poses, its indices, and where it goes on from.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/table_parts.h"
#include "kinetostat/report/manipulators/map.h"

namespace kinetostat::apps {

/// ROBOT.yaml with --grid or --path, --index, loads and --up-to.
struct MapRequest {
  std::string robot_file, grid, path, up_to;
  std::vector<std::string> indices;
  LoadRequest load;

  void add_options(OptionList& app);
  /// Throws UsageError; common::InputError for a path file.
  vjm::PoseList read_poses(const vjm::Robot& robot, const io::Part& part = {}) const;
  /// Throws UsageError, also for an index that makes no sense for these poses.
  std::vector<report::NamedIndex> read_indices(const vjm::Robot& robot,
                                               const vjm::PoseList& list) const;
};

}  // namespace kinetostat::apps
