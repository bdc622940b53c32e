#include "kinetostat/report/manipulators/joint_motion.h"

namespace kinetostat::report {

bool joint_turns(const vjm::Robot& robot, const std::string& name) {
  for (const vjm::Chain& chain : robot.manipulator.chains())
    for (const vjm::Coordinate& c : chain.coordinates())
      if (name == chain.name() + "." + c.name || name == c.name) return vjm::is_rotation(c.motion);
  return true;
}

}  // namespace kinetostat::report
