// The rigid body that an interface is glued to, so that a wrench can act on it (JAMRIS09 4.3).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/surface_mesh.h"

namespace kinetostat::fea {

/// A rigid body with six freedoms at `point`; every node of the interface follows it exactly. This
/// bounds the stiffness of the real fastening from above.
struct ReferenceBody {
  Vector3 point;           // [m]
  std::vector<int> nodes;  // of the mesh
};

/// Displacement of a node that follows a body: u = [I, -skew(arm)] [translation; rotation], with
/// the arm from the reference point to the node [m].
inline Eigen::Matrix<double, 3, 6> rigid_motion(const Vector3& arm) {
  Eigen::Matrix<double, 3, 6> motion;
  motion << Matrix3::Identity(), -spatial::skew(arm);
  return motion;
}

}  // namespace kinetostat::fea
