// A solid as tetrahedra of first or second order.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// A triangle of the boundary, seen counterclockwise from outside; first its corners, then, at
/// second order, the middles of its sides 01, 12, 20. `tag` says which part of the boundary.
struct BoundaryFace {
  std::array<int, 6> nodes;
  int tag;
};

/// A point where faces of two elements touch: barycentric coordinates in each, the outward normal
/// of the first, and the part of the area [m^2] that it stands for in integrals.
struct ContactPoint {
  Eigen::Vector4d in_first, in_second;
  Vector3 normal;
  double area = 0;
};

/// Where a face of one element touches one of an element of another body, and what is between them:
/// flexibility per area [m^3/N] along the normal and across it, 0 where they are bonded.
struct FaceContact {
  std::array<int, 2> elements = {};
  std::array<int, 2> faces = {};  // of the boundary
  double gap = 0;                 // [m] largest distance between the two
  /// [1/m] The area integral of a squared strain over the faces of each element that touch others
  /// is at most this times its volume integral.
  std::array<double, 2> trace = {};
  std::vector<ContactPoint> points = {};
  int joint = 0;  // number of the joint that it belongs to
  double normal_flexibility = 0, tangential_flexibility = 0;

  double area() const;  // [m^2]
};

/// Nodes [m] and elements: 4 corners, then at second order the middles of the edges
/// 01 12 20 03 13 23 (VTK's and CalculiX's order). The corner numbering is right-handed: the volume
/// (1-0) x (2-0) . (3-0) is positive.
struct TetMesh {
  int order = 1;
  std::vector<Vector3> nodes = {};
  std::vector<int> connectivity = {};
  std::vector<BoundaryFace> boundary = {};
  std::vector<int> materials = {};         // number of each element's material; empty: all 0
  std::vector<FaceContact> contacts = {};  // between bodies, which have no node in common
  /// Mid nodes are where a file put them, not all on the middles of their edges. Order 2 only.
  bool curved = false;
  std::string made_by = {};  // program that made the elements; empty: a file
  /// Mean distance [m] of each boundary face from the face of the CAD file that it stands for, as
  /// far as is known; empty: there is no CAD file.
  std::vector<double> gaps = {};
  std::size_t straightened = 0;  // elements at curved faces that curved edges would turn inside out

  std::size_t nodes_per_element() const { return order == 1 ? 4 : 10; }
  std::size_t nodes_per_face() const { return order == 1 ? 3 : 6; }
  std::size_t element_count() const { return connectivity.size() / nodes_per_element(); }
  std::span<const int> element(std::size_t e) const {
    return std::span(connectivity).subspan(e * nodes_per_element(), nodes_per_element());
  }
  std::array<Vector3, 4> corners(std::size_t e) const;
  std::size_t material_of(std::size_t e) const {
    return materials.empty() ? 0 : static_cast<std::size_t>(materials[e]);
  }
  /// Corners and mid nodes. Requires order 2.
  std::array<Vector3, 10> all_nodes(std::size_t e) const;
};

/// The pairs of corners whose middles are nodes 4 to 9.
inline constexpr std::array<std::array<int, 2>, 6> tet_edges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// The same for both directions of an edge, ascending with its smaller end, then its other.
constexpr std::uint64_t edge_key(int a, int b) {
  return static_cast<std::uint64_t>(a < b ? a : b) << 32 |
         static_cast<std::uint64_t>(a < b ? b : a);
}

/// Puts a node on the middle of every edge. Requires order 1.
TetMesh with_mid_nodes(const TetMesh& linear);

/// One mesh of several bodies that have no node in common; the number of the body is the material
/// of its elements. Requires meshes of the same order, without materials.
TetMesh side_by_side(const std::vector<TetMesh>& bodies);

/// Renumbers nodes and elements along a space-filling curve, so that neighbours are near in memory.
/// Requires order 1.
TetMesh reordered(const TetMesh& linear);

/// The numbers of the points in the order in which a space-filling curve passes them.
std::vector<int> along_curve(const std::vector<Vector3>& points);

/// Signed volume of a tetrahedron [m^3].
double volume(const std::array<Vector3, 4>& corners);

/// Smallest determinant of the map from the unit tetrahedron at the ten nodes, over six times the
/// volume of the corners: 1 for straight edges, 0 or less for an element that is turned inside out.
/// Requires order 2.
double least_jacobian(const TetMesh& mesh, std::size_t element);

struct MassProperties {
  double volume = 0;                        // [m^3]
  Vector3 centroid = Vector3::Zero();       // [m]
  Matrix3 second_moment = Matrix3::Zero();  // integral of r r' dV about the centroid [m^5]
};
MassProperties mass_properties(const TetMesh& mesh);
/// Of the elements of one material.
MassProperties mass_properties(const TetMesh& mesh, std::size_t material);
/// Mass properties of the solid within a closed surface that faces outwards.
MassProperties mass_properties(const SurfaceMesh& surface);

/// Inertia [kg m^2] about the centre of mass of a body of uniform density [kg/m^3].
Matrix3 inertia(const MassProperties& properties, double density);

struct MeshQuality {
  double least_dihedral = 0;   // [deg], over all elements
  double median_dihedral = 0;  // [deg], of the elements' least angles
  double largest_edge_ratio = 0;
  double mean_edge = 0;  // [m]
};
MeshQuality quality(const TetMesh& mesh);

/// Groups of elements that hang together over common nodes: 1 for a body in one piece.
int count_pieces(const TetMesh& mesh);

}  // namespace kinetostat::fea
