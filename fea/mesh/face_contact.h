// Where the bodies of a mesh touch, found from their boundary faces.
#pragma once

#include <vector>

#include "kinetostat/fea/mesh/tet_mesh.h"

namespace kinetostat::fea {

/// The contacts between the boundary of the first body and that of the second, which are the
/// elements with these material numbers: where the projection of a face of the second along the
/// normal of a face of the first overlaps it, the normals are opposed within 30 degrees, and no
/// point is farther from the other face than `within` [m]. The overlap is cut into triangles with
/// six points each, exact to fourth degree, so that over flat faces all products of shape functions
/// of both are integrated exactly (Dunavant 1985, Int. J. Numer. Meth. Engng 21:1129); edges of the
/// second's that curve within their face count as eight straight pieces. Bonded, in the order of
/// the first body's faces. `trace` is left 0 (set_traces()).
std::vector<FaceContact> find_contacts(const TetMesh& mesh, int first, int second, double within);

/// Fills in `trace` of all contacts of the mesh. An element of order p that touches with k faces
/// has k (p = 1) or k 8/3 (p = 2) times the area of the face over its volume (Warburton and
/// Hesthaven 2003, Comput. Methods Appl. Mech. Engng 192:2765, for strains of degree p - 1).
void set_traces(TetMesh& mesh);

/// The least distance [m] of a corner of one surface from the other.
double distance_between(const SurfaceMesh& one, const SurfaceMesh& other);

}  // namespace kinetostat::fea
