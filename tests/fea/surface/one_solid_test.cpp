// Shells as pictures have them become one solid; volumes are those of unions of boxes.
#include "kinetostat/fea/surface/one_solid.h"

#include <gtest/gtest.h>

#include "fea/shapes.h"
#include "fea/surface/cgal_helper.h"

namespace kinetostat::fea::one_solid_test {
namespace {

std::optional<OneSolid> solid_of(const SurfaceMesh& mesh) {
  common::Progress silent;
  return one_solid(mesh, {.helper = cgal_helper()}, silent);
}

double volume_of(const SurfaceMesh& mesh) {
  const SurfaceReport report = check_surface(mesh, weld_tolerance(mesh.points));
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.bodies(), 1);
  return report.volume;
}

const SurfaceMesh arm = box_surface({0, 0, 0}, {0.3, 0.04, 0.06});

// Without the face at its highest x: that is hidden in another body.
SurfaceMesh open_ended(SurfaceMesh box) {
  box.triangles.resize(box.triangles.size() - 2);
  return box;
}

TEST(OneSolid, IsTheMeshItselfWhereThatBoundsOne) {
  const auto solid = solid_of(arm);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->surface.triangles, arm.triangles);
  EXPECT_TRUE(solid->repairs.empty());
  EXPECT_EQ(solid->bodies, 1u);
}

TEST(OneSolid, IsTheLargestOfBodiesThatDoNotTouch) {
  SurfaceMesh both = box_surface({1, 1, 1}, {1.02, 1.02, 1.02});
  append(both, arm);
  const auto solid = solid_of(both);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->bodies, 2u);
  const double small = std::pow(0.02, 3), large = 0.3 * 0.04 * 0.06;
  EXPECT_NEAR(solid->share, large / (large + small), 1e-9);
  EXPECT_NEAR(volume_of(solid->surface), large, 1e-12);
}

#ifdef KINETOSTAT_CGAL
TEST(OneSolid, IsTheUnionOfShellsThatStickInEachOther) {
  SurfaceMesh shells = open_ended(arm);
  append(shells, box_surface({0.25, -0.02, -0.01}, {0.35, 0.06, 0.07}));
  const auto solid = solid_of(shells);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->bodies, 1u);
  EXPECT_NEAR(volume_of(solid->surface), 0.25 * 0.04 * 0.06 + 0.1 * 0.08 * 0.08, 1e-8);
}

TEST(OneSolid, IsNoneOfSheets) {
  SurfaceMesh sheet = arm;
  sheet.triangles.resize(2);
  EXPECT_FALSE(solid_of(sheet));
}
#endif

}  // namespace
}  // namespace kinetostat::fea::one_solid_test
