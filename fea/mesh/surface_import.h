// Surfaces of links, read from CAD exports.
#pragma once

#include <filesystem>
#include <string>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

struct ImportedSurface {
  SurfaceMesh mesh;
  WeldReport weld;
  std::string sha256;  // of the file
};

/// The unit in which lengths of this kind of file come, "" where the file does not know it: STEP is
/// converted to mm, COLLADA (DAE) to m.
std::string unit_of_format(const std::filesystem::path& file);

/// Reads STL (binary or ASCII), OBJ, PLY, DAE (its nodes applied, its axes as they are), the
/// triangles of a Gmsh file or, when the program gmsh is
/// installed, STEP (`unit` then does not matter), whose lengths are in `unit` ("mm"). Throws
/// InputError when the file is missing, truncated, empty, of another kind or not finite;
/// MissingUnit when `unit` is empty, with the bounding box in mm, m and inch to choose by.
ImportedSurface read_surface(const std::filesystem::path& file, const std::string& unit);

}  // namespace kinetostat::fea
