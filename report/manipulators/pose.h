// Poses as six numbers: position and rotation vector.
#pragma once

#include "kinetostat/io/json.h"
#include "kinetostat/spatial/pose.h"

namespace kinetostat::report {

/// [x, y, z, rx, ry, rz], base axes [m; rad].
spatial::Vector6 coordinates_of(const spatial::Pose& pose);
/// The same as `position` and `rotation_vector`.
io::Json to_json(const spatial::Pose& pose);

}  // namespace kinetostat::report
