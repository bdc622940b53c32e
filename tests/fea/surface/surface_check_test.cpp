#include "kinetostat/fea/surface/surface_check.h"

#include <chrono>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/surface/self_intersection.h"

#include "fea/shapes.h"

namespace kinetostat::fea::surface_check_test {
namespace {

constexpr double tolerance = 1e-6;
const SurfaceMesh box = box_surface({0, 0, 0}, {3, 2, 1});

std::vector<DefectKind> kinds(const SurfaceReport& report) {
  std::vector<DefectKind> list;
  for (const Defect& defect : report.defects) list.push_back(defect.kind);
  return list;
}

TEST(SurfaceCheck, ASoundBoxHasItsVolumeAndArea) {
  const SurfaceReport report = check_surface(box, tolerance);
  EXPECT_TRUE(report.sound());
  EXPECT_TRUE(report.defects.empty());
  EXPECT_NEAR(report.volume, 6, 1e-14);
  EXPECT_NEAR(report.area, 22, 1e-14);
  EXPECT_EQ(report.bodies(), 1);
  EXPECT_EQ(report.cavities(), 0);
}

TEST(SurfaceCheck, AMissingFacetLeavesThreeOpenEdges) {
  SurfaceMesh mesh = box;
  mesh.triangles.erase(mesh.triangles.begin() + 4);
  const SurfaceReport report = check_surface(mesh, tolerance);
  ASSERT_EQ(kinds(report), std::vector{DefectKind::open_edge});
  EXPECT_EQ(report.defects[0].count, 3u);
  EXPECT_EQ(report.defects[0].facets.size(), 3u);
  EXPECT_FALSE(report.sound());
}

TEST(SurfaceCheck, NamesTheFlippedFacetAndNoOther) {
  SurfaceMesh mesh = box;
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  const SurfaceReport report = check_surface(mesh, tolerance);
  ASSERT_EQ(kinds(report), std::vector{DefectKind::inconsistent_orientation});
  EXPECT_EQ(report.defects[0].facets, std::vector<int>{5});
  EXPECT_EQ(report.defects[0].count, 3u);
}

TEST(SurfaceCheck, AnInsideOutSurfaceIsSaidToBeOne) {
  const SurfaceReport report = check_surface(inverted(box), tolerance);
  EXPECT_EQ(kinds(report), std::vector{DefectKind::inside_out});
  EXPECT_NEAR(report.volume, -6, 1e-14);
}

TEST(SurfaceCheck, ACavityIsSound) {
  SurfaceMesh mesh = box;
  append(mesh, inverted(box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75})));
  const SurfaceReport report = check_surface(mesh, tolerance);
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.bodies(), 1);
  EXPECT_EQ(report.cavities(), 1);
  EXPECT_NEAR(report.volume, 5.5, 1e-14);
}

TEST(SurfaceCheck, ACavityFacingTheWrongWayIsInsideOut) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75}));
  const SurfaceReport report = check_surface(mesh, tolerance);
  ASSERT_EQ(kinds(report), std::vector{DefectKind::inside_out});
  EXPECT_EQ(report.defects[0].facets.size(), 12u);
  EXPECT_EQ(report.defects[0].facets.front(), 12);
}

TEST(SurfaceCheck, TwoBodiesAreCounted) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({5, 0, 0}, {6, 1, 1}));
  const SurfaceReport report = check_surface(mesh, tolerance);
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.bodies(), 2);
}

TEST(SurfaceCheck, BoxesThatPassThroughOneAnotherIntersect) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({1, 0.5, -1}, {2, 1.5, 3}));
  const SurfaceReport report = check_surface(mesh, tolerance);
  EXPECT_EQ(kinds(report), std::vector{DefectKind::self_intersection});
}

TEST(SurfaceCheck, ABoxCutSymmetricallyThroughItsDiagonalsIntersects) {
  SurfaceMesh mesh = box_surface({-1, -1, -1}, {1, 1, 1});
  append(mesh, box_surface({-0.5, -0.5, -2}, {0.5, 0.5, 2}));
  EXPECT_FALSE(check_surface(mesh, tolerance).sound());
}

TEST(SurfaceCheck, BoxesThatShareAPieceOfAPlaneOverlap) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({3, 0.5, 0.25}, {4, 1.5, 0.75}));
  EXPECT_EQ(kinds(check_surface(mesh, tolerance)), std::vector{DefectKind::self_intersection});
}

TEST(SurfaceCheck, NeighboursFoldedOntoOneAnotherIntersect) {
  SurfaceMesh mesh;
  mesh.points = {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0.2, 0.8, 0)};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  EXPECT_EQ(self_intersections(mesh, tolerance).pairs.size(), 1u);
  mesh.points[3].z() = 0.1;  // a sharp fold is not a defect
  EXPECT_TRUE(self_intersections(mesh, tolerance).pairs.empty());
}

TEST(SurfaceCheck, ADuplicateFacetIsNamed) {
  SurfaceMesh mesh = box;
  mesh.triangles.push_back(mesh.triangles[3]);
  const SurfaceReport report = check_surface(mesh, tolerance);
  EXPECT_EQ(kinds(report),
            (std::vector{DefectKind::non_manifold_edge, DefectKind::duplicate_facet}));
  EXPECT_EQ(report.defects[1].facets, std::vector<int>{12});
}

TEST(SurfaceCheck, ADegenerateFacetIsNamedButHarmless) {
  SurfaceMesh mesh = box;
  // A needle between corner 0, the middle of edge 0-1 and corner 1, as CAD programs leave them.
  const int middle = static_cast<int>(mesh.points.size());
  mesh.points.emplace_back(1.5, 0, 0);
  ASSERT_EQ(mesh.triangles[1], (Triangle{0, 3, 1}));
  mesh.triangles[1] = {0, 3, middle};
  mesh.triangles.push_back({middle, 3, 1});
  mesh.triangles.push_back({0, middle, 1});
  const SurfaceReport report = check_surface(mesh, tolerance);
  ASSERT_EQ(kinds(report), std::vector{DefectKind::degenerate_facet});
  EXPECT_EQ(report.defects[0].facets, std::vector<int>{13});
  EXPECT_TRUE(report.sound());
}

TEST(SurfaceCheck, TwoBoxesGluedAtAnEdgeAreNotManifold) {
  SurfaceMesh mesh = box_surface({0, 0, 0}, {1, 1, 1});
  append(mesh, box_surface({1, 1, 0}, {2, 2, 1}));
  weld(mesh, tolerance);
  const SurfaceReport report = check_surface(mesh, tolerance);
  EXPECT_EQ(kinds(report), std::vector{DefectKind::non_manifold_edge});
  EXPECT_EQ(report.defects[0].count, 1u);
}

TEST(SurfaceCheck, TheVerdictDoesNotDependOnPlaceTurnOrSize) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 20; ++round) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized();
    const double scale = std::pow(10.0, normal(random));
    SurfaceMesh sound = tube_surface(0.5, 1, 3, 24), crossed = sound;
    append(crossed, box_surface({0.7, -0.1, 1}, {2, 0.1, 2}));
    for (SurfaceMesh* mesh : {&sound, &crossed})
      for (Vector3& p : mesh->points) p = scale * (turn * p) + scale * Vector3(3, 5, -7);
    EXPECT_TRUE(check_surface(sound, weld_tolerance(sound.points)).defects.empty()) << round;
    EXPECT_EQ(kinds(check_surface(crossed, weld_tolerance(crossed.points))),
              std::vector{DefectKind::self_intersection});
  }
}

TEST(SurfaceCheck, SentencesNameFacetsFromOneAndTheCure) {
  SurfaceMesh mesh = box;
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  const auto lines = describe(check_surface(mesh, tolerance), "mm");
  EXPECT_THAT(lines.back(), testing::HasSubstr("facet 6"));
  EXPECT_THAT(lines.back(), testing::HasSubstr("unify normals"));
}

TEST(SurfaceCheck, OffendingFacetsCarryTheNameOfTheirDefect) {
  SurfaceMesh mesh = box;
  mesh.triangles.erase(mesh.triangles.begin() + 4);
  const SurfaceReport report = check_surface(mesh, tolerance);
  const io::VtuGrid grid = offending_facets(mesh, report);
  EXPECT_EQ(grid.connectivity.size(), 9u);
  ASSERT_EQ(grid.cell_fields.size(), 2u);
  EXPECT_EQ(grid.cell_fields[1].name, "open edge");
  EXPECT_EQ(grid.cell_fields[1].values, std::vector<double>(3, 1.0));
}

// A wavy torus of 100,000 facets: about a second is wanted, ten are a failure on any machine.
TEST(SurfaceCheck, AHundredThousandFacetsTakeAboutASecond) {
  constexpr int around = 500, across = 100;
  SurfaceMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * M_PI * i / around, v = 2 * M_PI * j / across;
      const double r = 3 + (1 + 0.1 * std::sin(9 * u)) * std::cos(v);
      mesh.points.emplace_back(r * std::cos(u), r * std::sin(u), std::sin(v));
    }
  const auto number = [](int i, int j) { return across * (i % around) + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
      mesh.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
    }
  ASSERT_EQ(mesh.triangles.size(), 100000u);
  const auto start = std::chrono::steady_clock::now();
  const SurfaceReport report = check_surface(mesh, weld_tolerance(mesh.points));
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  EXPECT_TRUE(report.defects.empty());
  EXPECT_GT(report.volume, 0);
  EXPECT_LT(elapsed.count(), 10);
  RecordProperty("seconds", std::to_string(elapsed.count()));
}

TEST(DoubtAboutUnit, IsRaisedForSpecksAndHouses) {
  const auto doubt = [](double metres) {
    return doubt_about_unit(Box(Vector3::Zero(), Vector3::Constant(metres)), "mm");
  };
  EXPECT_THAT(doubt(0.0003), testing::HasSubstr("0.00052 m across: is the unit of its file mm?"));
  EXPECT_THAT(doubt(300), testing::HasSubstr("520 m across"));
  EXPECT_EQ(doubt(0.003), "");
  EXPECT_EQ(doubt(30), "");
}

}  // namespace
}  // namespace kinetostat::fea::surface_check_test
