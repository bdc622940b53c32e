// Whether one spring per beam is enough for a loaded equilibrium.
#pragma once

#include <optional>

#include "kinetostat/apps/robot_request.h"
#include "kinetostat/files/json.h"

namespace kinetostat::apps {

/// Solves again with every beam in twice the segments: vjm::lumping_error(). Nothing without beams.
std::optional<double> lumping_error(const vjm::Robot& robot, const PostureRequest& posture,
                                    const LoadRequest& load, const vjm::Equilibrium& found);

/// A warning above 1 %; below, the error is stated when the robot has weight, which is lumped too.
std::string lumping_text(const vjm::Robot& robot, const std::optional<double>& error);

}  // namespace kinetostat::apps
