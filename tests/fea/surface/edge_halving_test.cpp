#include "kinetostat/fea/surface/edge_halving.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_topology.h"

#include "fea/shapes.h"

namespace kinetostat::fea::edge_halving_test {
namespace {

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

TEST(EdgeHalving, LeavesWhatIsSmall) {
  const SurfaceMesh box = box_surface({0, 0, 0}, {0.1, 0.1, 0.1});
  EXPECT_EQ(halve_edges(box, 0.2).triangles, box.triangles);
}

}  // namespace
}  // namespace kinetostat::fea::edge_halving_test
