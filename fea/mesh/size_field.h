// How large the elements shall be, and where.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// Edge lengths [m] of regular tetrahedra, wished for at points [m]: an element takes the wish of
/// the point that is nearest to its centroid. Empty: no wish.
struct SizeField {
  std::vector<Vector3> points = {};
  std::vector<double> sizes = {};

  bool empty() const { return points.empty(); }
};

/// From the shape alone: about as large as the material is thick along the inward normal, as the
/// radius of curvature, or a tenth of the diagonal, whichever is smallest; all larger by one factor
/// where that would give more than 40000 triangles on the surface. Requires a sound surface.
SizeField size_from_surface(const SurfaceMesh& surface);

/// From an error on a mesh, `error_of[e]` >= 0 from element e. The mesh with the fewest elements
/// whose errors sum to a share of the present sum has, with elements of order p, h_new = h (K /
/// error)^(1/(2p + 3)) where stresses are smooth [Zienkiewicz and Zhu 1987, Int. J. Numer. Meth.
/// Engng 24:337; elements that are expensive because they are small are refined less]. Beside an
/// edge where they are singular as r^(lambda - 1) the error falls as h^(2 lambda), and the exponent
/// is 1/(2 lambda + 3). Refined elements have the larger exponent, that of lambda = 3/4, for most
/// of the error is there; coarsened ones have the smaller one. K follows from the aim. Sizes change
/// by a factor of 1/5 to 1.5.
struct RefinementAim {
  double share = 0.5;                        // of the present error, in (0, 1]
  double least_growth = 1, most_growth = 8;  // of the number of elements, whatever the error
};
SizeField size_from_error(const TetMesh& mesh, const std::vector<double>& error_of,
                          const RefinementAim& aim);

}  // namespace kinetostat::fea
