// Commands along a path that take errors away, for people, spreadsheets and programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/uncertainty/draws.h"
#include "kinetostat/vjm/workspace/compensation.h"

namespace kinetostat::report {

/// What was computed for each pose of `path`, in its order.
struct CompensatedPath {
  const vjm::Robot& robot;
  const vjm::PoseList& path;
  const std::vector<vjm::Compensation>& points;
  /// Of six numbers a pose, [m; rad]: where a robot that is not quite the one of the file stands
  /// beside the target.
  std::optional<vjm::Uncertainty> uncertainty = {};
};

/// Largest and root mean square error of the platform, before and after, in the units of the robot
/// file.
/// How far the platform is off, with and without the corrected targets.
std::string headline(const CompensatedPath& result);
std::string text(const CompensatedPath& result);
/// The same and every pose, in SI units.
io::Json to_json(const CompensatedPath& result);
/// One row a pose: target, load, error, modified target, actuators, what is left; in the units of
/// the robot file.
std::string csv(const CompensatedPath& result);
/// What the charts of a page need.
io::Json picture(const CompensatedPath& result);

}  // namespace kinetostat::report
