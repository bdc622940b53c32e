// Force against deflection along a path of equilibria, as `trace` follows it.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/json.h"
#include "kinetostat/vjm/continuation/path.h"
#include "kinetostat/vjm/statics/segments.h"

namespace kinetostat::apps {

/// The options of `trace`.
struct TraceRequest {
  PostureRequest posture;
  LoadRequest load;
  UncertaintyRequest uncertainty;
  vjm::PathOptions path;
  std::vector<int> segments{1, 2, 4};
  bool hold = false;  // the platform, under loads at nodes

  vjm::PathTask task(const vjm::Robot& robot) const;
};

struct TracedPath {
  vjm::Robot robot;
  vjm::PathTask task = {};
  vjm::Posture posture = {};
  vjm::Path path = {};
  std::optional<vjm::SegmentStudy> segments = {};    // of beams that may buckle
  std::optional<vjm::Uncertainty> uncertainty = {};  // of force [N] and deflection [m]

  /// Whether the uncertain numbers are those of the first critical point, else of the path's end.
  bool is_critical() const { return !path.critical.empty(); }
  /// Which of them the budget is of: 0 the force, 1 the deflection.
  Eigen::Index shown() const { return is_critical() || task.platform_held ? 0 : 1; }
};

/// Throws UsageError, and common::NoConvergence where there is no equilibrium to start from. A path
/// that is lost on its way stops the run short.
TracedPath traced_path(const TraceRequest& request, Run& run);
/// As `trace` has it.
io::Json to_json(const TracedPath& result);

}  // namespace kinetostat::apps
