#include "kinetostat/fea/mesh/tet_mesh.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "fea/shapes.h"

namespace kinetostat::fea::tet_mesh_test {
namespace {

TEST(TetMesh, MidNodesLieOnTheMiddlesOfTheirEdgesAndAreShared) {
  const TetMesh linear = box_mesh({2, 1, 1}, 2, 1, 1);
  const TetMesh mesh = with_mid_nodes(linear);
  std::set<std::pair<int, int>> edges;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto tet = mesh.element(e);
    for (std::size_t k = 0; k < 6; ++k) {
      const int a = tet[static_cast<std::size_t>(tet_edges[k][0])];
      const int b = tet[static_cast<std::size_t>(tet_edges[k][1])];
      edges.insert(std::minmax(a, b));
      const Vector3 middle =
          0.5 * (mesh.nodes[static_cast<std::size_t>(a)] + mesh.nodes[static_cast<std::size_t>(b)]);
      EXPECT_EQ(mesh.nodes[static_cast<std::size_t>(tet[4 + k])], middle);
    }
  }
  EXPECT_EQ(mesh.nodes.size(), linear.nodes.size() + edges.size());
}

TEST(TetMesh, BoundaryMidNodesBelongToTheirSides) {
  const TetMesh mesh = with_mid_nodes(box_mesh({2, 1, 1}, 2, 2, 1));
  ASSERT_EQ(mesh.boundary.size(), 8u);
  for (const BoundaryFace& face : mesh.boundary)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = [&](std::size_t i) {
        return mesh.nodes[static_cast<std::size_t>(face.nodes[i])];
      };
      EXPECT_EQ(p(3 + k), Vector3(0.5 * (p(k) + p((k + 1) % 3))));
    }
}

TEST(TetMesh, MassPropertiesOfABox) {
  const double a = 0.3, b = 0.2, c = 0.1;
  const MassProperties box = mass_properties(box_mesh({a, b, c}, 3, 2, 2));
  EXPECT_NEAR(box.volume, a * b * c, 1e-15);
  EXPECT_NEAR((box.centroid - 0.5 * Vector3(a, b, c)).norm(), 0, 1e-15);
  const Matrix3 tensor = inertia(box, 1000);
  const double mass = 1000 * a * b * c;
  EXPECT_NEAR(tensor(0, 0), mass / 12 * (b * b + c * c), 1e-14);
  EXPECT_NEAR(tensor(1, 1), mass / 12 * (a * a + c * c), 1e-14);
  EXPECT_NEAR(tensor(2, 2), mass / 12 * (a * a + b * b), 1e-14);
  EXPECT_NEAR(tensor(0, 1), 0, 1e-14);
}

TEST(TetMesh, ReorderingKeepsTheSolidAndItsBoundary) {
  const TetMesh before = box_mesh({3, 2, 1}, 6, 4, 2);
  const TetMesh after = reordered(before);
  EXPECT_EQ(after.element_count(), before.element_count());
  EXPECT_EQ(after.nodes.size(), before.nodes.size());
  EXPECT_NEAR(mass_properties(after).volume, 6, 1e-13);
  EXPECT_NEAR((mass_properties(after).centroid - Vector3(1.5, 1, 0.5)).norm(), 0, 1e-13);
  for (const BoundaryFace& face : after.boundary)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(after.nodes[static_cast<std::size_t>(face.nodes[k])].x(), face.tag == 1 ? 0 : 3);
}

TEST(TetMesh, QualityOfARegularTetrahedron) {
  TetMesh mesh{
      .nodes = {Vector3(1, 1, 1), Vector3(1, -1, -1), Vector3(-1, 1, -1), Vector3(-1, -1, 1)},
      .connectivity = {0, 2, 1, 3}};
  ASSERT_GT(volume(mesh.corners(0)), 0);
  const MeshQuality regular = quality(mesh);
  EXPECT_NEAR(regular.least_dihedral, 70.528779365509308, 1e-12);  // arccos(1/3)
  EXPECT_NEAR(regular.largest_edge_ratio, 1, 1e-15);
  EXPECT_NEAR(regular.mean_edge, 2 * std::sqrt(2.0), 1e-14);
}

TEST(TetMesh, CountsPieces) {
  TetMesh mesh = box_mesh({1, 1, 1}, 1, 1, 1);
  EXPECT_EQ(count_pieces(mesh), 1);
  const int base = static_cast<int>(mesh.nodes.size());
  for (int i = 0; i < base; ++i)
    mesh.nodes.emplace_back(mesh.nodes[static_cast<std::size_t>(i)] + Vector3(5, 0, 0));
  for (int i = 0; i < 24; ++i)
    mesh.connectivity.push_back(mesh.connectivity[static_cast<std::size_t>(i)] + base);
  EXPECT_EQ(count_pieces(mesh), 2);
}

}  // namespace
}  // namespace kinetostat::fea::tet_mesh_test
