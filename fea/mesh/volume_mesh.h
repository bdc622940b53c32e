// The volume mesh of a link, made by another program and read from its file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/fea/mesh/mesh_file.h"
#include "kinetostat/fea/mesh/tet_mesh.h"
#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// Elements that go by one name in the file.
struct ElementGroup {
  std::string name;
  std::vector<int> elements;  // ascending
};

struct ImportedVolume {
  /// Order 1 or 2 as in the file; mid nodes where the file has them. All outside faces are in
  /// `boundary`, with tag 0.
  TetMesh mesh;
  /// The outside: facet f is mesh.boundary[f]; its groups are those of faces, surfaces and nodes of
  /// the file (the faces whose nodes are all in the set).
  SurfaceMesh surface;
  std::vector<ElementGroup> element_groups = {};  // by name
  std::vector<std::string> warnings = {};
  std::string sha256 = {};  // of the file
};

/// True when the file is one that read_volume_mesh reads and holds tetrahedra: every .inp, and a
/// .msh that is not just a surface. Throws InputError when the file cannot be read.
bool holds_volume_mesh(const std::filesystem::path& file);

/// Reads .msh and .inp whose lengths are in `unit`. Nodes that no tetrahedron uses are left out.
/// Throws InputError with the line: besides what parse_msh() and parse_inp() refuse, mixed orders,
/// elements that are flat or turned inside out (all of them mirrored is repaired with a warning),
/// elements that share a side three times, mid nodes that differ between neighbours; MissingUnit.
/// With a `body`, only the elements of the group of that name, as a solid of their own.
ImportedVolume read_volume_mesh(const std::filesystem::path& file, const std::string& unit,
                                const std::string& body = {});

/// The mesh alone, of order 1, in the file's unit: every outside face must be one of the triangles
/// of the group "surface N", and gets the tag N - 1. Throws InputError.
TetMesh tagged_volume(const FileMesh& file);

/// The triangles of a file without tetrahedra, with their groups; unwelded, in the file's unit.
SurfaceMesh triangles_of(const FileMesh& file);

}  // namespace kinetostat::fea
