// A configuration of a loaded manipulator.
#pragma once

#include <vector>

#include "kinetostat/spatial/pose.h"

namespace kinetostat::vjm {

/// All that the equations of equilibrium are solved for.
struct SystemState {
  std::vector<spatial::Pose> bodies;         // the platform first, base axes
  std::vector<spatial::Vector6> wrenches;    // on the chain ends [N; N m], base axes
  std::vector<Eigen::VectorXd> coordinates;  // all of each chain [m or rad]
};

}  // namespace kinetostat::vjm
