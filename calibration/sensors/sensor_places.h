// The parts of a robot that can carry a sensor or its target.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/effects/watch.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::calibration {

struct SensorPlace {
  std::string name;  // as campaign files name it: "platform", "arm.base", "arm.elbow"
  vjm::CarriedFrame frame;
};

/// Bodies, then of each chain its base, nodes, joints and links; without the base itself.
std::vector<SensorPlace> sensor_places(const vjm::Manipulator& robot);

}  // namespace kinetostat::calibration
