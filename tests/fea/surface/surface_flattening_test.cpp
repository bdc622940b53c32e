#include "kinetostat/fea/surface/surface_flattening.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "fea/shapes.h"

namespace kinetostat::fea::surface_flattening_test {
namespace {

double farthest_move(const SurfaceMesh& a, const SurfaceMesh& b) {
  double farthest = 0;
  for (std::size_t p = 0; p < a.points.size(); ++p)
    farthest = std::max(farthest, (a.points[p] - b.points[p]).norm());
  return farthest;
}

TEST(Flatten, MovesCornersIntoTheirPlanesAndNotFar) {
  SurfaceMesh mesh = box_surface({0, 0, 0}, {3, 2, 1});
  mesh.points[7] += Vector3(1e-4, -2e-4, 1e-4);  // three faces are twisted by it
  const SurfaceMesh before = mesh;
  EXPECT_GT(flatten(mesh, 1e-3), 0u);
  EXPECT_LT(farthest_move(mesh, before), 3e-4);
  for (std::size_t f = 0; f + 1 < mesh.triangles.size(); f += 2)  // the two facets of a face
    EXPECT_LT(mesh.area_vector(f).normalized().cross(mesh.area_vector(f + 1).normalized()).norm(),
              1e-7);
}

TEST(Flatten, LeavesWhatIsBentMore) {
  SurfaceMesh mesh = box_surface({0, 0, 0}, {3, 2, 1});
  mesh.points[7] += Vector3(0.01, -0.02, 0.01);
  const SurfaceMesh before = mesh;
  flatten(mesh, 1e-3);
  EXPECT_LT(farthest_move(mesh, before), 1e-12);
}

// The chords of 400 sides are off the circle by less than the tolerance; it is round all the same.
TEST(Flatten, LeavesRoundFacesRound) {
  SurfaceMesh mesh = tube_surface(0.5, 1, 1, 400);
  const SurfaceMesh before = mesh;
  flatten(mesh, 1e-3);
  EXPECT_LT(farthest_move(mesh, before), 1e-12);
}

}  // namespace
}  // namespace kinetostat::fea::surface_flattening_test
