#include "kinetostat/fea/mesh/flat_elements.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/fea/mesh/tetrahedralize.h"

#include "fea/shapes.h"

namespace kinetostat::fea::flat_elements_test {
namespace {

TetMesh filled_box() {
  TetrahedralizeOptions options;
  options.edge_length = 0.3;
  options.helper = KINETOSTAT_TETGEN;
  common::Progress silent;
  return tetrahedralize(box_surface({0, 0, 0}, {1, 1, 1}), std::vector<int>(12, 3), options,
                        silent);
}

std::vector<bool> on_boundary(const TetMesh& mesh) {
  std::vector<bool> is(mesh.nodes.size(), false);
  for (const BoundaryFace& face : mesh.boundary)
    for (std::size_t k = 0; k < 3; ++k) is[static_cast<std::size_t>(face.nodes[k])] = true;
  return is;
}

// Moves an inner node almost into the side opposite to it in some element, where that turns none of
// the others inside out.
void flatten_an_inner_element(TetMesh& mesh, double height) {
  const std::vector<bool> outside = on_boundary(mesh);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto tip = static_cast<std::size_t>(mesh.element(e)[k]);
      if (outside[tip]) continue;
      const auto corners = mesh.corners(e);
      const auto p = [&](std::size_t i) { return corners[(k + i) % 4]; };
      const Vector3 before = mesh.nodes[tip], centre = (p(1) + p(2) + p(3)) / 3;
      mesh.nodes[tip] = centre + height * (before - centre);
      bool all_positive = true;
      for (std::size_t other = 0; other < mesh.element_count(); ++other)
        all_positive = all_positive && volume(mesh.corners(other)) > 0;
      if (all_positive) return;
      mesh.nodes[tip] = before;
    }
  FAIL() << "every inner node turns an element inside out";
}

TEST(FlatElements, FullnessOfTheRegularTetrahedronIsItsVolumeAtEdgeOne) {
  EXPECT_NEAR(fullness({Vector3(1, 1, 1), {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}),
              1 / (6 * std::sqrt(2.0)), 1e-15);
  EXPECT_EQ(fullness({Vector3(0, 0, 0), {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), 0);
}

TEST(FlatElements, AMeshWithoutAnyIsLeftAlone) {
  TetMesh mesh = filled_box();
  const TetMesh before = mesh;
  EXPECT_FALSE(has_flat_elements(mesh));
  EXPECT_EQ(remove_flat_elements(mesh), 0u);
  EXPECT_EQ(mesh.connectivity, before.connectivity);
}

TEST(FlatElements, AnInnerOneGoesAndTheSolidStays) {
  TetMesh mesh = filled_box();
  flatten_an_inner_element(mesh, 1e-11);
  ASSERT_TRUE(has_flat_elements(mesh));
  EXPECT_EQ(remove_flat_elements(mesh), 0u);
  EXPECT_FALSE(has_flat_elements(mesh));
  double sum = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    EXPECT_GT(volume(mesh.corners(e)), 0) << e;
    sum += volume(mesh.corners(e));
  }
  EXPECT_NEAR(sum, 1, 1e-9);
}

TEST(FlatElements, OneOnAFaceIsPeeledOffAndItsTagStays) {
  // A flat element lies on the side 0 2 1 of another: its outer faces are the boundary there.
  TetMesh mesh;
  mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1}, {0.3, 0.3, -1e-13}};
  const std::vector<int> full{0, 1, 2, 3}, flat{0, 2, 1, 4};
  mesh.connectivity = full;
  mesh.connectivity.insert(mesh.connectivity.end(), flat.begin(), flat.end());
  for (const Triangle& t : {Triangle{0, 1, 3}, {1, 2, 3}, {2, 0, 3}})
    mesh.boundary.push_back({.nodes = {t[0], t[1], t[2], -1, -1, -1}, .tag = 0});
  for (const Triangle& t : {Triangle{1, 0, 4}, {2, 1, 4}, {0, 2, 4}})
    mesh.boundary.push_back({.nodes = {t[0], t[1], t[2], -1, -1, -1}, .tag = 7});
  ASSERT_TRUE(has_flat_elements(mesh));
  EXPECT_EQ(remove_flat_elements(mesh), 0u);
  ASSERT_EQ(mesh.element_count(), 1u);
  EXPECT_NEAR(mass_properties(mesh).volume, 1.0 / 6, 1e-15);
  int tagged = 0;
  for (const BoundaryFace& face : mesh.boundary) tagged += face.tag == 7 ? 1 : 0;
  EXPECT_EQ(mesh.boundary.size(), 4u);
  EXPECT_EQ(tagged, 1);
}

}  // namespace
}  // namespace kinetostat::fea::flat_elements_test
