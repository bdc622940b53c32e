// The part of a link's surface where it is held or loaded, picked the way an engineer points at it.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// All facets that lie in the plane and face along its normal (out of the material).
struct PlaneSelector {
  Vector3 point;   // [m]
  Vector3 normal;  // unit
};
/// All facets of a bore or boss: corners at the radius, normals radial. With `length`, only those
/// between axis_point and axis_point + length * axis.
struct CylinderSelector {
  Vector3 axis_point;            // [m]
  Vector3 axis;                  // unit
  double radius;                 // [m]
  std::optional<double> length;  // [m]
};
/// All facets with their three corners in the box.
struct BoxSelector {
  Box box;  // [m]
};
/// The flat face first met by the ray from the point along the direction.
struct NearestFaceSelector {
  Vector3 point;      // [m]
  Vector3 direction;  // unit
};
/// All facets of a spherical socket or ball: corners at the radius, normals radial.
struct SphereSelector {
  Vector3 center;  // [m]
  double radius;   // [m]
};
/// All facets of a group that the mesh file names (FacetGroup).
struct GroupSelector {
  std::string name;
};
/// All facets that lie on the triangles of another surface, which need not be the same triangles.
struct PatchSelector {
  SurfaceMesh patch;
  std::string sha256 = {};  // of its file
};
/// All facets of the faces of a CAD file that have this name, or this one's number.
struct CadFaceSelector {
  std::string name = {};
  int number = 0;  // from 1; 0: by name
};
/// All facets of the faces of a CAD file that have this colour.
struct ColourSelector {
  std::string colour;  // "#rrggbb", lower case
};
using Selector =
    std::variant<PlaneSelector, CylinderSelector, BoxSelector, NearestFaceSelector, SphereSelector,
                 GroupSelector, PatchSelector, CadFaceSelector, ColourSelector>;

/// Facets of the surface (from 0, ascending). Empty when there are none. Distances agree to 1e-4 of
/// the diagonal of the bounding box, radii also to 1 %, normals of planes to 1 degree.
std::vector<int> select_facets(const SurfaceMesh& surface, const Selector& selector);

/// Selections near the one asked for, in a sentence; lengths in `unit`.
std::string nearest_candidates(const SurfaceMesh& surface, const Selector& selector,
                               const std::string& unit);

/// A selected interface on the volume mesh.
struct Interface {
  int tag = 0;             // of its boundary faces
  std::vector<int> nodes;  // of the mesh, ascending
  std::size_t faces = 0;
  double area = 0;   // [m^2]
  Vector3 centroid;  // [m]
  /// Radii of gyration [m] of the area along its principal axes (columns), descending: for a flat
  /// face the last axis is its normal and the last radius 0.
  Vector3 gyration;
  Matrix3 principal_axes;
};

/// The boundary faces with this tag (tetrahedralize.h).
Interface interface_on(const TetMesh& mesh, int tag);

}  // namespace kinetostat::fea
