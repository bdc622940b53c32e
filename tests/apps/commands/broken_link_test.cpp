// Links that are wrong in one way each: the message names the place and what to do, and nothing
// crashes or hangs.
#include <array>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/run_program.h"

namespace kinetostat::broken_link_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

using Point = std::array<double, 3>;
using Facet = std::array<Point, 3>;

// The twelve facets of a cube of side 10 with one corner at (x, x, x), outward normals.
std::vector<Facet> cube(double x = 0) {
  const auto corner = [x](int i) {
    return Point{x + 10.0 * (i & 1), x + 10.0 * (i >> 1 & 1), x + 10.0 * (i >> 2 & 1)};
  };
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::vector<Facet> facets;
  for (const auto& f : faces) {
    facets.push_back({corner(f[0]), corner(f[1]), corner(f[2])});
    facets.push_back({corner(f[0]), corner(f[2]), corner(f[3])});
  }
  return facets;
}

std::vector<Facet> without_last(std::vector<Facet> facets) {
  facets.pop_back();
  return facets;
}

std::vector<Facet> one_flipped(std::vector<Facet> facets) {
  std::swap(facets[3][0], facets[3][1]);
  return facets;
}

std::vector<Facet> both(std::vector<Facet> a, const std::vector<Facet>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::string stl(const std::vector<Facet>& facets) {
  std::string text = "solid test\n";
  for (const Facet& facet : facets) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const Point& p : facet) text += fmt::format("  vertex {} {} {}\n", p[0], p[1], p[2]);
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid test\n";
}

// A sound link file, with one piece of text replaced by another.
std::string link(const std::string& from = "", const std::string& to = "") {
  std::string text =
      "kinetostat: 1\n"
      "link: cube\n"
      "mesh: {file: cube.stl, unit: mm}\n"
      "material: {E: 70 GPa, nu: 0.33, density: 2700 kg/m^3}\n"
      "fixed: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}\n"
      "loaded: {plane: {point: [10, 0, 0], normal: [1, 0, 0]}, point: [10, 5, 5], coupling: "
      "rigid}\n"
      "elements: {order: 2, size: 5}\n";
  if (from.empty()) return text;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

struct Mistake {
  const char* name;
  std::string link, stl;
  std::vector<std::string> message;
};

class BrokenLink : public testing::TestWithParam<Mistake> {
 protected:
  Outcome identify(const std::string& link_file, const std::string& stl_file) {
    std::ofstream(working_folder() / "cube.yaml") << link_file;
    std::ofstream(working_folder() / "cube.stl") << stl_file;
    return kinetostat("identify cube.yaml -o cube.link.json");
  }
};

TEST_F(BrokenLink, SoundLinkIsIdentified) {
  const Outcome outcome = identify(link(), stl(cube()));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::remove(working_folder() / "cube.link.json"));
}

TEST_P(BrokenLink, IsBadInputWithItsPlaceNamed) {
  const Outcome outcome = identify(GetParam().link, GetParam().stl);
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  for (const std::string& part : GetParam().message) EXPECT_THAT(outcome.err, HasSubstr(part));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "cube.link.json"));
}

INSTANTIATE_TEST_SUITE_P(
    File, BrokenLink,
    testing::Values(
        Mistake{"no_unit",
                link(", unit: mm", ""),
                stl(cube()),
                {"cube.yaml:3", "no unit", "bounding box", "unit: mm"}},
        Mistake{
            "empty_unit", link("unit: mm", "unit: "), stl(cube()), {"cube.yaml:3", "mesh.unit"}},
        Mistake{
            "unknown_unit", link("unit: mm", "unit: mmm"), stl(cube()), {"cube.yaml:3", "'mm'"}},
        Mistake{"not_a_length", link("unit: mm", "unit: kg"), stl(cube()), {"cube.yaml:3", "kg"}},
        Mistake{"no_mesh", link("cube.stl", "cub.stl"), stl(cube()), {"cube.yaml:3", "'cube.stl'"}},
        Mistake{"misspelt_key",
                link("material", "matreial"),
                stl(cube()),
                {"cube.yaml:4", "'material'"}},
        Mistake{"missing_key", link("nu: 0.33, ", ""), stl(cube()), {"cube.yaml:4", "'nu'"}},
        Mistake{
            "negative_modulus", link("70 GPa", "-70 GPa"), stl(cube()), {"cube.yaml:4", "-70 GPa"}},
        Mistake{"modulus_unit", link("70 GPa", "70 mm"), stl(cube()), {"cube.yaml:4", "70 mm"}},
        Mistake{"incompressible", link("0.33", "0.5"), stl(cube()), {"cube.yaml:4", "0.5"}},
        Mistake{"zero_normal", link("[-1, 0, 0]", "[0, 0, 0]"), stl(cube()), {"cube.yaml:5"}},
        Mistake{"not_a_number",
                link("[10, 5, 5]", "[10, five, 5]"),
                stl(cube()),
                {"cube.yaml:6", "five"}},
        Mistake{"negative_size", link("size: 5", "size: -5"), stl(cube()), {"cube.yaml:7", "-5"}},
        Mistake{"order_three", link("order: 2", "order: 3"), stl(cube()), {"cube.yaml:7", "3"}},
        Mistake{"nothing_fixed", link("[0, 0, 0]", "[4, 0, 0]"), stl(cube()), {"cube.yaml:5"}},
        Mistake{"overlapping",
                link("[10, 0, 0], normal: [1,", "[0, 0, 0], normal: [-1,"),
                stl(cube()),
                {"cube.yaml"}}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Surface, BrokenLink,
    testing::Values(
        Mistake{"open", link(), stl(without_last(cube())), {"cube.stl", "open"}},
        Mistake{"flipped", link(), stl(one_flipped(cube())), {"cube.stl", "faces the other way"}},
        Mistake{
            "self_intersecting", link(), stl(both(cube(), cube(5))), {"cube.stl", "facets cross"}},
        Mistake{"doubled_facet", link(), stl(both(cube(), {cube()[0]})), {"cube.stl"}},
        Mistake{"two_bodies", link(), stl(both(cube(), cube(50))), {"cube.stl"}},
        Mistake{"empty_file", link(), "", {"cube.stl"}},
        Mistake{"no_facets", link(), stl({}), {"cube.stl"}},
        Mistake{"not_a_mesh", link(), "Lorem ipsum dolor sit amet\n", {"cube.stl"}},
        Mistake{"cut_off", link(), stl(cube()).substr(0, 700), {"cube.stl"}},
        Mistake{"not_finite", link(), stl({{{{0, 0, 0}, {1, 0, 0}, {0, 1e39, 0}}}}), {"cube.stl"}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace kinetostat::broken_link_test
