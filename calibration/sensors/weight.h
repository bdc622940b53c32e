// Weights that are hung on parts of a robot.
#pragma once

#include <string>

#include "kinetostat/vjm/statics/load.h"

namespace kinetostat::calibration {

/// A place where weights hang, by its column; `per_kilogram` is the load of 1 kg there, at the node
/// that with_watched() has made for it.
struct Weight {
  std::string name;
  vjm::NodeLoad per_kilogram;
};

/// All forces at nodes together [N].
spatial::Vector3 force_at_nodes(const vjm::Load& load);

}  // namespace kinetostat::calibration
