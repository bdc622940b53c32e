// Unstructured grids for ParaView: VTK's XML format, one file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kinetostat::io {

/// VTK's cell numbers; the order of nodes is VTK's (quadratic_tetra: corners 0..3, then the middles
/// of 01 12 20 03 13 23).
enum class VtuCell : std::uint8_t {
  vertex = 1,
  line = 3,
  triangle = 5,
  quad = 9,
  tetra = 10,
  hexahedron = 12,
  quadratic_triangle = 22,
  quadratic_tetra = 24
};

/// Values at the points or in the cells, `components` consecutive numbers each.
struct VtuField {
  std::string name;
  int components = 1;
  std::vector<double> values = {};
};

/// Cells of one kind. Points are x, y, z in turn.
struct VtuGrid {
  std::vector<double> points = {};
  VtuCell cell = VtuCell::triangle;
  int nodes_per_cell = 3;
  std::vector<int> connectivity = {};  // nodes_per_cell point numbers per cell
  std::vector<VtuField> point_fields = {};
  std::vector<VtuField> cell_fields = {};
};

/// Binary (base64) arrays inside valid XML. Throws std::invalid_argument when a field does not have
/// one value per point or cell.
std::string vtu_text(const VtuGrid& grid);
/// The same, written atomically.
void write_vtu(const std::filesystem::path& file, const VtuGrid& grid);

}  // namespace kinetostat::io
