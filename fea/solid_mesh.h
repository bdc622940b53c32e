// A closed surface filled with tetrahedra by whoever can: TetGen, TetGen on a cleaned surface,
// Gmsh.
#pragma once

#include <vector>

#include "kinetostat/fea/tet_mesh.h"
#include "kinetostat/fea/tetrahedralize.h"
#include "kinetostat/files/progress.h"

namespace kinetostat::fea {

/// As tetrahedralize(). Where TetGen fails on the surface as it is, thin facets are removed (within
/// a millionth, then a hundred-thousandth of the diagonal), then Gmsh is tried when it is
/// installed; `made_by` of the mesh says who did it. When all fail, the MeshingError is that of the
/// first attempt and says what else was tried.
TetMesh fill_solid(const SurfaceMesh& surface, const std::vector<int>& tags,
                   const TetrahedralizeOptions& options, files::Progress& progress);

}  // namespace kinetostat::fea
