#include "kinetostat/report/manipulators/pose.h"

#include "kinetostat/spatial/rotation.h"

namespace kinetostat::report {

spatial::Vector6 coordinates_of(const spatial::Pose& pose) {
  spatial::Vector6 c;
  c << pose.position(), spatial::log_rotation(pose.rotation());
  return c;
}

io::Json to_json(const spatial::Pose& pose) {
  return {{"position", io::to_json(pose.position())},
          {"rotation_vector", io::to_json(spatial::log_rotation(pose.rotation()))}};
}

}  // namespace kinetostat::report
