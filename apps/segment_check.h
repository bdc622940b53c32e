// Whether one spring per beam is enough for a loaded equilibrium.
#pragma once

#include <optional>

#include "kinetostat/apps/robot_request.h"
#include "kinetostat/files/json.h"

namespace kinetostat::apps {

/// Solves again with every beam in twice the segments. The springs of a straight unloaded beam are
/// exact with any number; under load the difference is the share of geometric stiffness that lumped
/// springs miss. Returns Richardson's estimate of the relative error of the displacement under the
/// load (or of the wrench that holds a displacement); nothing without beams or when either does not
/// converge.
std::optional<double> lumping_error(const vjm::Robot& robot, const PostureRequest& posture,
                                    const LoadRequest& load, const vjm::Equilibrium& found);

/// A warning above 1 %; below, the error is stated when the robot has weight, which is lumped too.
std::string lumping_text(const vjm::Robot& robot, const std::optional<double>& error);

}  // namespace kinetostat::apps
