// Surfaces of links, read from CAD exports.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/fea/surface/step_program.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct ImportedSurface {
  SurfaceMesh mesh;
  WeldReport weld;
  std::string sha256;     // of the file
  std::string step = {};  // its bytes, when it is a STEP file
};

/// The unit in which lengths of this kind of file come, "" where the file does not know it: STEP
/// comes in mm, COLLADA (DAE) in m.
std::string unit_of_format(const std::filesystem::path& file);

/// Reads STL (binary or ASCII), OBJ, PLY, DAE (its nodes applied, its axes as they are) or the
/// triangles of a Gmsh file, whose lengths are in `unit` ("mm"), or STEP, cut into `facets` when
/// kinetostat was built with Open CASCADE (`unit` then does not matter). Throws InputError when the
/// file is missing, truncated, empty, of another kind or not finite; MissingUnit when `unit` is
/// empty, with the bounding box in mm, m and inch to choose by.
ImportedSurface read_surface(const std::filesystem::path& file, const std::string& unit,
                             const StepFacets& facets = {});

}  // namespace kinetostat::fea
