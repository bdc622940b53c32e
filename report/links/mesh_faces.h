// The faces of a mesh file, each with the selector that picks it in a link file.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"
#include "kinetostat/io/json.h"
#include "kinetostat/report/links/mesh_check.h"

namespace kinetostat::report {

/// Of a STEP file all faces, in their order, with name and colour; of other files the flat and
/// round faces that the facets show, the largest first, at most forty. Lengths in `units`.
std::string faces_text(const fea::SurfaceMesh& surface, const MeshCheckUnits& units);

/// The same in SI units; the selectors are texts in `units`.
io::Json faces_json(const fea::SurfaceMesh& surface, const MeshCheckUnits& units);

/// The selectors of a boundary's flat and round faces, and which of them each facet has; -1: none.
struct FaceSelectors {
  std::vector<std::string> selectors;
  std::vector<int> of_facets;
};
FaceSelectors face_selectors(const fea::SurfaceMesh& boundary, const MeshCheckUnits& units);

}  // namespace kinetostat::report
