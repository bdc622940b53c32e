#include "kinetostat/fea/mesh/edge_division.h"

#include <algorithm>
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

double longest_edge(const SurfaceMesh& surface) {
  double longest = 0;
  for (const EdgeUse& use : edge_uses(surface))
    longest = std::max(longest, (surface.points[static_cast<std::size_t>(use.high)] -
                                 surface.points[static_cast<std::size_t>(use.low)])
                                    .norm());
  return longest;
}

// Height over longest side, of the flattest facet.
double flattest(const SurfaceMesh& surface) {
  double least = 1;
  for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
    const SurfaceMesh alone{.points = surface.points, .triangles = {surface.triangles[f]}};
    const double longest = longest_edge(alone);
    least = std::min(least, 2 * surface.area_vector(f).norm() / (longest * longest));
  }
  return least;
}

// A rod 60 times as long as thick, as CAD programs write them: facets from end to end.
TEST(EdgeHalving, MakesFacetsOfTheSizeAndNoFlatterOnes) {
  const SurfaceMesh rod = box_surface({0, 0, 0}, {0.3, 0.005, 0.005});
  const SurfaceMesh halved = halve_edges(rod, 0.01);
  EXPECT_GT(longest_edge(halved), 0.005);
  EXPECT_LE(longest_edge(halved), 0.01);
  EXPECT_LT(halved.triangles.size(), 1000u);
  EXPECT_GT(flattest(rod), 0.01);
  EXPECT_GT(flattest(halved), 0.25);  // half a square: 1 / 2
  const SurfaceReport report = check_surface(halved, 1e-9);
  EXPECT_TRUE(report.sound());
  EXPECT_TRUE(report.defects.empty());
  EXPECT_NEAR(report.volume, 0.3 * 0.005 * 0.005, 1e-17);
}

// Points in one line on a side are no corners of facets without height.
TEST_F(EdgeDivision, HalvesWhatIsDividedAlready) {
  for (const double longest : {0.05, 0.008, 0.002}) {
    const SurfaceMesh halved = halve_edges(divide_edges(box_, faces_, field_).mesh, longest);
    EXPECT_LE(longest_edge(halved), longest);
    const SurfaceReport report = check_surface(halved, 1e-7);
    EXPECT_TRUE(report.sound()) << longest;
    EXPECT_TRUE(report.defects.empty()) << longest;
    EXPECT_NEAR(report.volume, 1e-5, 1e-17);
  }
}

TEST(EdgeHalving, LeavesWhatIsSmall) {
  const SurfaceMesh box = box_surface({0, 0, 0}, {0.1, 0.1, 0.1});
  EXPECT_EQ(halve_edges(box, 0.2).triangles, box.triangles);
}

}  // namespace
}  // namespace kinetostat::fea::edge_division_test
