// The faces of the solid that a triangulated surface came from: flat ones and round ones.
#pragma once

#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// Facets connected in one plane.
struct FlatFace {
  std::vector<int> facets;  // ascending
  Vector3 centroid;         // [m]
  Vector3 normal;           // outward, unit
  double area = 0;          // [m^2]
};

/// Small flat faces around an axis: a bore or a boss, whole or in part.
struct RoundFace {
  std::vector<int> facets;
  Vector3 axis_point;  // on the axis, at the middle of the face [m]
  Vector3 axis;        // unit, first non-zero component positive
  double radius = 0;   // [m]
  double length = 0;   // along the axis [m]
};

/// Every facet belongs to exactly one flat face (a curved surface gives many small ones). Corners
/// within `tolerance` [m] of a plane are in it.
std::vector<FlatFace> flat_faces(const SurfaceMesh& mesh, double tolerance);

/// Cylinders fitted to neighbouring flat faces that turn by small angles, in strips or any other
/// triangles; corners agree with the radius within 1 %.
std::vector<RoundFace> round_faces(const SurfaceMesh& mesh, const std::vector<FlatFace>& flat);

}  // namespace kinetostat::fea
