// A surface with facets of a size at most.
#pragma once

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// The same surface, edges halved until none is longer than `longest` [m], which is above zero:
/// first those between facets of two planes, then those within one, the longest first (Rivara
/// 1984). Within a plane (to 1e-5 rad), diagonals are exchanged for shorter ones, so that facets
/// from end to end of a rod do not become splinters. Without groups.
SurfaceMesh halve_edges(const SurfaceMesh& surface, double longest);

}  // namespace kinetostat::fea
