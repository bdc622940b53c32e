// Nodes of the boundary put onto the faces of the CAD file that the surface came from.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/step_program.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// The faces of a STEP file, and which of them each boundary face of a mesh stands for (from 1; 0:
/// none).
struct CadBoundary {
  const std::string& step;  // bytes of the file
  const std::vector<CadFace>& faces;
  std::vector<int> face_of = {};
  StepLimits limits = {};
};

/// Boundary nodes are moved to the nearest points of their faces, those between two faces onto the
/// common edge; inner nodes follow harmonically, so that small elements beside a coarse facet keep
/// their shape. At second order the middles of edges lie on the faces, too: the elements there are
/// curved. Elements that would lose their shape (a node's Jacobian below a fifth of that with
/// straight edges, or the element four fifths of its fullness) stay as they were, and are counted
/// in `straightened`; `gaps` says how far all faces then are from those of the file. Requires
/// order 1. Throws StepError, Cancelled.
TetMesh on_cad_faces(const TetMesh& linear, const CadBoundary& cad, int order,
                     common::Progress& progress);

}  // namespace kinetostat::fea
