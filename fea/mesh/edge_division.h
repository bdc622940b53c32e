// The edges of a surface divided before it is meshed.
#pragma once

#include <cstdint>
#include <vector>

#include "kinetostat/fea/mesh/size_field.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct DividedSurface {
  SurfaceMesh mesh;         // the same surface: new points lie on its edges; without groups
  std::vector<int> parent;  // of each facet: the facet that it is a part of
};

/// Halves edges between facets of different faces, `face_of[facet]`, until none is longer than
/// twice the size wished for at its middle, and divides the facets beside them accordingly. Edges
/// within a face stay: a mesher may ignore them. The surface is unchanged when the field is empty.
///
/// TetGen 1.5 splits edges of the surface by itself, but gives up at some of them and leaves
/// elements a hundred times larger than asked for, just where re-entrant edges need them small.
DividedSurface divide_edges(const SurfaceMesh& surface, const std::vector<std::int32_t>& face_of,
                            const SizeField& sizes);

/// The same surface, edges halved until none is longer than `longest` [m], which is above zero:
/// first those between facets of two planes, then those within one, the longest first (Rivara
/// 1984). Within a plane (to 1e-5 rad), diagonals are exchanged for shorter ones, so that facets
/// from end to end of a rod do not become splinters. Without groups.
SurfaceMesh halve_edges(const SurfaceMesh& surface, double longest);

}  // namespace kinetostat::fea
