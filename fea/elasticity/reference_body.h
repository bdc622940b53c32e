// The rigid body that an interface is glued to, so that a wrench can act on it (JAMRIS09 4.3).
#pragma once

#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// A rigid body with six freedoms at `point`; every node of the interface follows it exactly. This
/// bounds the stiffness of the real fastening from above.
struct ReferenceBody {
  Vector3 point;           // [m]
  std::vector<int> nodes;  // of the mesh
};

}  // namespace kinetostat::fea
