// Volumes are those of the round bodies in closed form.
#include "kinetostat/fea/mesh/primitive_surface.h"

#include <cmath>

#include <gtest/gtest.h>

#include "kinetostat/fea/surface/surface_check.h"

namespace kinetostat::fea::primitive_surface_test {
namespace {

void expect_solid(const SurfaceMesh& mesh, double volume, const Vector3& half) {
  const SurfaceReport report = check_surface(mesh, weld_tolerance(mesh.points));
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.bodies(), 1);
  EXPECT_NEAR(report.volume / volume, 1, 3e-3);
  EXPECT_NEAR((bounding_box(mesh.points).max() - half).norm(), 0, 3e-3 * half.norm());
  EXPECT_NEAR((bounding_box(mesh.points).min() + half).norm(), 0, 3e-3 * half.norm());
}

TEST(PrimitiveSurface, BoundsWhatItIsNamedAfter) {
  constexpr double r = 0.05, l = 0.3;
  const double ball = 4 * M_PI / 3 * r * r * r, column = M_PI * r * r * l;
  expect_solid(box_surface({-0.1, -0.2, -0.3}, {0.1, 0.2, 0.3}), 0.048, {0.1, 0.2, 0.3});
  expect_solid(cylinder_surface(r, l), column, {r, r, l / 2});
  expect_solid(capsule_surface(r, l), column + ball, {r, r, l / 2 + r});
  expect_solid(capsule_surface(r, 0), ball, {r, r, r});
}

TEST(PrimitiveSurface, OfACylinderHasTheSectionOfTheCircle) {
  const SurfaceMesh mesh = cylinder_surface(0.05, 0.3);
  EXPECT_NEAR(check_surface(mesh, weld_tolerance(mesh.points)).volume, M_PI * 0.0025 * 0.3, 1e-15);
}

}  // namespace
}  // namespace kinetostat::fea::primitive_surface_test
