// Natural frequencies and modes of a robot in a posture, as `modes` finds them.
#pragma once

#include <optional>
#include <string>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/io/json.h"
#include "kinetostat/report/screen/modes.h"

namespace kinetostat::apps {

/// The options of `modes` that are about robots.
struct RobotModesRequest {
  PostureRequest robot;
  LoadRequest load;
  UncertaintyRequest uncertainty;
  bool weight = false;                         // about the equilibrium under it
  int modes = 6;                               // at most, from the lowest on
  std::string response;                        // "FROM:TO[:STEPS]" [Hz]; empty: none
  std::optional<double> damping, loss_factor;  // of the response
};

struct RobotModesResult {
  vjm::Robot robot;
  vjm::Posture posture;
  report::RobotModes modes;
};

/// Throws UsageError, common::InputError for a robot without masses, and common::NoConvergence.
RobotModesResult modes_of_robot(const RobotModesRequest& request, Run& run);
/// As `modes` writes it.
io::Json to_json(const RobotModesResult& result);

}  // namespace kinetostat::apps
