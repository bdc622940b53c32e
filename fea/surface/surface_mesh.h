// The boundary of a link as triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "kinetostat/spatial/linear_algebra.h"

namespace kinetostat::fea {

using spatial::Matrix3;
using spatial::Matrix6;
using spatial::Vector3;
using spatial::Vector6;
using Box = Eigen::AlignedBox3d;
using Triangle = std::array<int, 3>;

/// Corners in ascending order: the same for a facet and for the same facet seen from behind.
inline Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// Facets that go by one name in the file: a solid of an STL file, an object or group of an OBJ
/// file, a physical surface of Gmsh.
struct FacetGroup {
  std::string name;
  std::vector<int> facets;  // ascending
};

/// What a face of a CAD file lies on.
enum class FaceKind { other, plane, cylinder, cone, sphere, torus };
inline constexpr std::array<const char*, 6> face_kinds{"other", "plane",  "cylinder",
                                                       "cone",  "sphere", "torus"};

/// A face of the CAD file that the surface came from.
struct CadFace {
  std::string name = {};    // may be empty, and several may have the same
  std::string colour = {};  // "#rrggbb", lower case; empty: none
  FaceKind kind = FaceKind::other;
  double area = 0;                      // [m^2]
  Vector3 centre = Vector3::Zero();     // [m] of the area
  Vector3 point = Vector3::Zero();      // [m] on the plane or the axis, or the centre of a sphere
  Vector3 direction = Vector3::Zero();  // unit: outward normal of a plane, else of the axis
  double radius = 0;                    // [m] of a cylinder or sphere, of the tube of a torus
  int solid = 0;                        // number of its solid, from 1; 0: none
  std::string solid_name = {};          // may be empty, and several may have the same
};

/// Name of the group of the facets of face `number`, from 1.
std::string group_of_face(std::size_t number);

/// Points [m] shared by triangles whose corners run counterclockwise seen from outside.
struct SurfaceMesh {
  std::vector<Vector3> points = {};
  std::vector<Triangle> triangles = {};
  std::vector<FacetGroup> groups = {};  // in the order of the file
  std::vector<CadFace> faces = {};      // of a CAD file; the facets of each are a group

  const Vector3& corner(std::size_t facet, std::size_t k) const {
    return points[static_cast<std::size_t>(triangles[facet][k])];
  }
  Vector3 centroid(std::size_t facet) const {
    return (corner(facet, 0) + corner(facet, 1) + corner(facet, 2)) / 3;
  }
  /// Area times the outward unit normal [m^2].
  Vector3 area_vector(std::size_t facet) const {
    return 0.5 * (corner(facet, 1) - corner(facet, 0)).cross(corner(facet, 2) - corner(facet, 0));
  }
};

/// The points and triangles of another behind its own; groups and faces stay as they are.
void append(SurfaceMesh& mesh, const SurfaceMesh& other);

/// [m^2] of all facets, or of some.
double area_of(const SurfaceMesh& mesh);
double area_of(const SurfaceMesh& mesh, const std::vector<int>& facets);

/// The face of the CAD file that each facet belongs to, from 1; 0: none.
std::vector<int> face_of_facets(const SurfaceMesh& surface);

/// Distance [m] along the ray to the facet, or infinity; `direction` is a unit vector.
double ray_hit(const SurfaceMesh& surface, std::size_t facet, const Vector3& from,
               const Vector3& direction);

Box bounding_box(const std::vector<Vector3>& points);

/// Result of welding.
struct WeldReport {
  double tolerance = 0;  // [m]: points nearer than this became one
  std::size_t points_before = 0, points_after = 0;
  std::vector<int> collapsed =
      {};  // facets of the file (from 0) that lost a corner and were left out
};

/// Gives coinciding corners one point: identical ones first, then those nearer than `tolerance` [m]
/// to a point already kept. The result does not depend on anything but the order of the points.
/// Facets that collapse are left out and reported.
WeldReport weld(SurfaceMesh& mesh, double tolerance);

/// Points nearer than `tolerance` [m] to one already kept become one with it; `points` shrinks to
/// the kept ones. Returns the new number of each point.
std::vector<int> merge_near(std::vector<Vector3>& points, double tolerance);

/// The tolerance that read_surface welds with: a millionth of the diagonal of the bounding box, or
/// the rounding of 32-bit coordinates when the part lies far from the origin.
double weld_tolerance(const std::vector<Vector3>& points);

/// Leaves out the points that no facet has; the others keep their order. Whatever works on points
/// counts on that: a mesher would put nodes there.
void drop_unused_points(SurfaceMesh& mesh);

/// Keeps the facets whose number in `kept` is not -1, under that number, with their points and
/// groups; kept numbers ascend from 0.
void keep_facets(SurfaceMesh& mesh, const std::vector<int>& kept);

/// The surface as a binary STL file, its lengths in units of `metres`.
std::string stl_bytes(const SurfaceMesh& mesh, double metres);

}  // namespace kinetostat::fea
