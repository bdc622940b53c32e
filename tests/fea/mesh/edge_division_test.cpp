#include "kinetostat/fea/mesh/edge_division.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_topology.h"

#include "fea/shapes.h"

namespace kinetostat::fea::edge_division_test {
namespace {

// The two facets of each side of a box are one face.
class EdgeDivision : public testing::Test {
 protected:
  SurfaceMesh box_ = box_surface({0, 0, 0}, {0.1, 0.01, 0.01});
  std::vector<std::int32_t> faces_{1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6};
  // Small elements wished for at the corner in the origin.
  SizeField field_{.points = {{0, 0, 0}, {0.01, 0, 0}, {0.1, 0, 0}}, .sizes = {0.0005, 0.002, 0.1}};

  double wish(const Vector3& point) const {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < field_.points.size(); ++i)
      if ((field_.points[i] - point).norm() < (field_.points[nearest] - point).norm()) nearest = i;
    return field_.sizes[nearest];
  }
};

TEST_F(EdgeDivision, LeavesTheSurfaceWhereItIs) {
  const DividedSurface divided = divide_edges(box_, faces_, field_);
  const SurfaceReport report = check_surface(divided.mesh, 1e-9);
  EXPECT_TRUE(report.sound());
  EXPECT_TRUE(report.defects.empty());  // no facet without area either
  EXPECT_NEAR(report.volume, 1e-5, 1e-17);
  std::vector<Vector3> area(box_.triangles.size(), Vector3::Zero());
  for (std::size_t f = 0; f < divided.mesh.triangles.size(); ++f)
    area[static_cast<std::size_t>(divided.parent[f])] += divided.mesh.area_vector(f);
  for (std::size_t f = 0; f < area.size(); ++f)
    EXPECT_LT((area[f] - box_.area_vector(f)).norm(), 1e-15);
}

TEST_F(EdgeDivision, DividesEdgesOfFacesAsWishedAndNoOthers) {
  const DividedSurface divided = divide_edges(box_, faces_, field_);
  EXPECT_GT(divided.mesh.triangles.size(), 40u);
  for_each_edge(edge_uses(divided.mesh), [&](auto first, auto last) {
    ASSERT_EQ(last - first, 2);
    const Vector3 &a = divided.mesh.points[static_cast<std::size_t>(first->low)],
                  &b = divided.mesh.points[static_cast<std::size_t>(first->high)];
    const auto face = [&](auto use) {
      const int parent = divided.parent[static_cast<std::size_t>(use->facet)];
      return faces_[static_cast<std::size_t>(parent)];
    };
    if (face(first) != face(first + 1)) {
      EXPECT_LE((b - a).norm(), 2 * wish(0.5 * (a + b)));
    }
  });
  for (std::size_t p = box_.points.size(); p < divided.mesh.points.size(); ++p) {
    const Vector3 &x = divided.mesh.points[p], whole(x.x() / 0.1, x.y() / 0.01, x.z() / 0.01);
    int within = 0;  // on an edge of the box two coordinates are at their ends
    for (Eigen::Index k = 0; k < 3; ++k) within += whole[k] > 0 && whole[k] < 1 ? 1 : 0;
    EXPECT_EQ(within, 1);
  }
}

TEST_F(EdgeDivision, DoesNothingWithoutAWish) {
  const DividedSurface divided = divide_edges(box_, faces_, {});
  EXPECT_EQ(divided.mesh.triangles, box_.triangles);
  EXPECT_EQ(divided.mesh.points.size(), box_.points.size());
}

}  // namespace
}  // namespace kinetostat::fea::edge_division_test
