#include "kinetostat/io/vtu.h"

#include <bit>
#include <cstring>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/io/base64.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

static_assert(std::endian::native == std::endian::little, "the header below says LittleEndian");

template <class Value>
std::string data_array(const char* type, const std::string& name, int components,
                       const std::vector<Value>& values) {
  const std::uint64_t size = values.size() * sizeof(Value);
  std::string bytes(sizeof size + size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values.data(), size);
  return fmt::format(
      "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n"
      "          {}\n        </DataArray>\n",
      type, name, components, base64(bytes));
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : common::printable(text)) {  // XML has no control characters, and is UTF-8
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

std::string fields(const char* element, const std::vector<VtuField>& list, std::size_t count) {
  std::string text = fmt::format("      <{}>\n", element);
  for (const VtuField& field : list) {
    if (field.values.size() != count * static_cast<std::size_t>(field.components))
      throw std::invalid_argument(fmt::format("field '{}' has {} values, expected {} times {}",
                                              field.name, field.values.size(), count,
                                              field.components));
    text += data_array("Float64", escaped(field.name), field.components, field.values);
  }
  return text + fmt::format("      </{}>\n", element);
}

std::string cells(const VtuGrid& grid, std::size_t count) {
  std::vector<std::int64_t> offsets(count);
  for (std::size_t i = 0; i < count; ++i)
    offsets[i] = static_cast<std::int64_t>(i + 1) * grid.nodes_per_cell;
  const std::vector<std::uint8_t> types(count, static_cast<std::uint8_t>(grid.cell));
  return "      <Cells>\n" + data_array("Int32", "connectivity", 1, grid.connectivity) +
         data_array("Int64", "offsets", 1, offsets) + data_array("UInt8", "types", 1, types) +
         "      </Cells>\n";
}

}  // namespace

std::string vtu_text(const VtuGrid& grid) {
  const std::size_t point_count = grid.points.size() / 3;
  const std::size_t cell_count =
      grid.connectivity.size() / static_cast<std::size_t>(grid.nodes_per_cell);
  return fmt::format(
             "<?xml version=\"1.0\"?>\n"
             "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
             "header_type=\"UInt64\">\n"
             "  <UnstructuredGrid>\n"
             "    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
             point_count, cell_count) +
         fields("PointData", grid.point_fields, point_count) +
         fields("CellData", grid.cell_fields, cell_count) + "      <Points>\n" +
         data_array("Float64", "Points", 3, grid.points) + "      </Points>\n" +
         cells(grid, cell_count) +
         "    </Piece>\n"
         "  </UnstructuredGrid>\n"
         "</VTKFile>\n";
}

void write_vtu(const std::filesystem::path& file, const VtuGrid& grid) {
  write_atomically(file, vtu_text(grid));
}

}  // namespace kinetostat::io
