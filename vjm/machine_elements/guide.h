// Linear guides: the 6x6 stiffness of a table on its carriages.
#pragma once

#include <vector>

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::vjm {

/// What a catalogue says of one carriage on its rail along x: stiffness across it [N/m], and
/// against turns about its own centre [N m/rad], as far as it says so.
struct Carriage {
  double lateral = 0, normal = 0;                     // along y and z
  double roll = 0, pitch = 0, yaw = 0;                // about x, y and z
  spatial::Vector3 place = spatial::Vector3::Zero();  // of its centre [m]
};

/// d[F; M]/d[u; theta] of the table at the origin: carriages beside each other resist turns by how
/// far they are apart. Nothing resists a motion along x.
spatial::Matrix6 guide_stiffness(const std::vector<Carriage>& carriages);

}  // namespace kinetostat::vjm
