#include "kinetostat/io/vtu.h"

#include <cstring>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetostat::io::vtu_test {
namespace {

VtuGrid one_triangle() {
  return {.points = {0, 0, 0, 1, 0, 0, 0, 1, 0},
          .cell = VtuCell::triangle,
          .nodes_per_cell = 3,
          .connectivity = {0, 1, 2},
          .point_fields = {{"u", 3, {1, 2, 3, 4, 5, 6, 7, 8, 9}}},
          .cell_fields = {{"a \"b\" <c>", 1, {0.5}}}};
}

std::string decoded(const std::string& base64) {
  static const std::string digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255u);
  }
  return bytes;
}

// The payload of the array with this name: eight bytes of length, then the data.
std::string payload(const std::string& text, const std::string& name) {
  std::size_t at = text.find("Name=\"" + name + "\"");
  at = text.find_first_not_of(" \n", text.find('>', at) + 1);
  const std::string bytes = decoded(text.substr(at, text.find('\n', at) - at));
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  EXPECT_EQ(size, bytes.size() - sizeof size);
  return bytes.substr(sizeof size);
}

TEST(Vtu, ArraysReadBackAsWritten) {
  const VtuGrid grid = one_triangle();
  const std::string text = vtu_text(grid);
  std::vector<double> points(9), u(9);
  std::memcpy(points.data(), payload(text, "Points").data(), 9 * sizeof(double));
  std::memcpy(u.data(), payload(text, "u").data(), 9 * sizeof(double));
  EXPECT_EQ(points, grid.points);
  EXPECT_EQ(u, grid.point_fields[0].values);
  EXPECT_EQ(payload(text, "types"), std::string(1, '\5'));
  std::int64_t offset = 0;
  std::memcpy(&offset, payload(text, "offsets").data(), sizeof offset);
  EXPECT_EQ(offset, 3);
  EXPECT_THAT(text, testing::HasSubstr("NumberOfPoints=\"3\" NumberOfCells=\"1\""));
}

TEST(Vtu, NamesAreEscaped) {
  EXPECT_THAT(vtu_text(one_triangle()), testing::HasSubstr("Name=\"a &quot;b&quot; &lt;c>\""));
}

TEST(Vtu, AnEmptyGridIsStillAFile) {
  EXPECT_THAT(vtu_text({}), testing::HasSubstr("NumberOfCells=\"0\""));
}

TEST(Vtu, RefusesAFieldOfTheWrongLength) {
  VtuGrid grid = one_triangle();
  grid.cell_fields[0].values.push_back(1);
  EXPECT_THROW(vtu_text(grid), std::invalid_argument);
}

}  // namespace
}  // namespace kinetostat::io::vtu_test
