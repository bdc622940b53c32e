// Content of a mesh file of a finite-element program, as read.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "kinetostat/fea/surface/surface_mesh.h"

namespace kinetostat::fea {

/// A tetrahedron of a file, or a triangle. Nodes in the order of tet_mesh.h: corners, then the
/// middles of 01 12 20 03 13 23; of a triangle: corners only.
struct FileTet {
  std::array<int, 10> nodes{-1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
  int node_count = 4;  // 4 or 10
  int number = 0;      // as the file has it
  int line = 0;        // 0 in a binary file
};

/// Everything that goes by one name in a file.
struct FileGroup {
  std::vector<int> triangles = {}, tets = {}, nodes = {};  // indices into FileMesh
  std::vector<std::pair<int, int>> sides = {};  // of tets: 0 opposite the last corner, see below
};

/// The sides of a tetrahedron, S1 to S4 of Abaqus and CalculiX, seen from outside.
inline constexpr std::array<std::array<int, 3>, 4> tet_sides{
    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

struct FileMesh {
  std::vector<Vector3> points = {};  // in the file's unit
  std::vector<FileTet> tets = {};
  std::vector<Triangle> triangles = {};  // surface elements, as in groups of faces
  std::map<std::string, FileGroup> groups = {};
};

/// Gmsh's .msh, format 2.2 or 4.1, ASCII or binary; groups are its physical groups, "surface 3"
/// where one has no name. `bytes` is the content of `file`. Throws InputError with the line.
FileMesh parse_msh(const std::filesystem::path& file, const std::string& bytes);

/// The input deck of Abaqus or CalculiX: *NODE, *ELEMENT (C3D4, C3D10, and triangles), *ELSET,
/// *NSET, *SURFACE; everything else is passed over. Throws InputError with the line.
FileMesh parse_inp(const std::filesystem::path& file, const std::string& bytes);

}  // namespace kinetostat::fea
