#include "kinetostat/fea/surface/surface_repair.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/mesh/edge_division.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/surface/surface_bodies.h"
#include "kinetostat/fea/surface/surface_distance.h"
#include "kinetostat/fea/surface/surface_faces.h"
#include "kinetostat/fea/surface/surface_weld.h"
#include "kinetostat/io/text_file.h"

#include "fea/shapes.h"
#include "fea/surface/cgal_helper.h"
#include "support/temporary_folder.h"

namespace kinetostat::fea::surface_repair_test {
namespace {

using testing::HasSubstr;

constexpr double tolerance = 1e-6;
const SurfaceMesh box = box_surface({0, 0, 0}, {3, 2, 1});

// As an exporter writes facets: no corner shared, each off by up to `error`.
SurfaceMesh unwelded(const SurfaceMesh& mesh, double error) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-error / 2, error / 2);
  SurfaceMesh soup;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const int base = static_cast<int>(soup.points.size());
    for (std::size_t k = 0; k < 3; ++k)
      soup.points.push_back(mesh.corner(f, k) + Vector3(off(random), off(random), off(random)));
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  return soup;
}

// Many facets a side, their corners on the edges of the box.
SurfaceMesh fine_box() {
  return divide_edges(box, {1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6},
                      {.points = {Vector3::Zero()}, .sizes = {0.25}})
      .mesh;
}

RepairReport mend(SurfaceMesh& mesh, std::vector<RepairStep> steps, double limit = 0.01) {
  common::Progress silent;
  RepairOptions options;
  options.steps = std::move(steps);
  options.limit = limit;
  options.helper = cgal_helper();
  return repair(mesh, options, silent);
}

void expect_sound(const SurfaceMesh& mesh, double volume, double precision) {
  const SurfaceReport report = check_surface(mesh, tolerance);
  EXPECT_TRUE(report.sound()) << testing::PrintToString(describe(report, "m"));
  EXPECT_EQ(report.bodies(), 1);
  EXPECT_NEAR(report.volume, volume, precision * volume);
}

TEST(Repair, LeavesASoundSurfaceAlone) {
  SurfaceMesh mesh = box;
  const RepairReport report = mend(mesh, {RepairStep::weld, RepairStep::orient});
  EXPECT_TRUE(report.actions.empty());
  EXPECT_EQ(mesh.triangles, box.triangles);
}

TEST(Repair, WeldJoinsCornersOfOpenEdges) {
  SurfaceMesh mesh = unwelded(box, 1e-4);
  EXPECT_FALSE(check_surface(mesh, tolerance).sound());
  const RepairReport report = mend(mesh, {RepairStep::weld});
  ASSERT_EQ(report.actions.size(), 1u);
  EXPECT_THAT(report.actions[0].words, HasSubstr("28 corners joined"));
  expect_sound(mesh, 6, 1e-3);
}

// A mesher would put nodes at points that no facet has.
TEST(Repair, WeldLeavesNoPointsBehind) {
  SurfaceMesh mesh = unwelded(box, 1e-4);
  mend(mesh, {RepairStep::weld});
  EXPECT_EQ(mesh.points.size(), 8u);
}

TEST(Repair, WeldMakesFlatFacesFlatAgain) {
  SurfaceMesh mesh = unwelded(fine_box(), 1e-4);
  mend(mesh, {RepairStep::weld});
  expect_sound(mesh, 6, 1e-3);
  EXPECT_EQ(flat_faces(mesh, 1e-12).size(), 6u);
}

TEST(Repair, DropLeavesOutSmallBodiesThatTouchNothing) {
  SurfaceMesh mesh = box;
  append(mesh, inverted(box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75})));
  append(mesh, box_surface({1.4, 0.9, 0.4}, {1.6, 1.1, 0.6}));  // floats in the cavity
  append(mesh, box_surface({5, 0, 0}, {5.2, 0.2, 0.2}));
  EXPECT_EQ(find_bodies(mesh, nested_shells(mesh, edge_uses(mesh))).size(), 3u);
  SurfaceMesh kept = mesh;
  EXPECT_FALSE(mend(kept, {RepairStep::drop}, 1e-3).actions.at(0).done);
  EXPECT_EQ(kept.triangles, mesh.triangles);
  EXPECT_TRUE(mend(kept, {RepairStep::drop}, 0.01).actions.at(0).done);
  expect_sound(kept, 5.5, 1e-12);
  EXPECT_EQ(kept.points.size(), 16u);
}

TEST(Repair, WeldMovesNothingWhereTheSurfaceIsClosed) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({3 + 1e-5, 0, 0}, {4, 2, 1}));  // nearer than the tolerance, but closed
  const std::vector<Vector3> before = mesh.points;
  weld_open_edges(mesh, 1e-3);
  EXPECT_EQ(mesh.points, before);
  EXPECT_EQ(check_surface(mesh, tolerance).bodies(), 2);
}

TEST(Repair, WeldCutsEdgesAtCornersThatLieOnThem) {
  SurfaceMesh mesh = box;
  // One of two neighbours is cut at two points of their common edge.
  const Triangle whole = mesh.triangles[0];
  const int p = static_cast<int>(mesh.points.size()), q = p + 1;
  const Vector3 a = mesh.corner(0, 0), b = mesh.corner(0, 1);
  mesh.points.emplace_back(a + 0.3 * (b - a));
  mesh.points.emplace_back(a + 0.6 * (b - a));
  mesh.triangles[0] = {whole[0], p, whole[2]};
  mesh.triangles.push_back({p, q, whole[2]});
  mesh.triangles.push_back({q, whole[1], whole[2]});
  EXPECT_FALSE(check_surface(mesh, tolerance).sound());
  EXPECT_EQ(weld_open_edges(mesh, 1e-4).split, 1u);
  expect_sound(mesh, 6, 1e-12);
}

TEST(Repair, RepeatedFacetsGoButOne) {
  SurfaceMesh mesh = box;
  mesh.triangles.push_back(box.triangles[3]);
  mesh.triangles.push_back({box.triangles[7][0], box.triangles[7][2], box.triangles[7][1]});
  EXPECT_EQ(remove_repeated_facets(mesh), 2u);
  expect_sound(mesh, 6, 1e-12);
}

TEST(Repair, ASurfaceThatIsThereTwiceIsHalved) {
  SurfaceMesh mesh = box;
  mesh.triangles.insert(mesh.triangles.end(), box.triangles.begin(), box.triangles.end());
  EXPECT_EQ(remove_repeated_facets(mesh), 12u);
  expect_sound(mesh, 6, 1e-12);
}

TEST(Repair, TheWallBetweenTwoBodiesThatShareItGoes) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({3, 0, 0}, {5, 2, 1}));
  weld(mesh, tolerance);
  EXPECT_FALSE(check_surface(mesh, tolerance).sound());
  EXPECT_EQ(remove_repeated_facets(mesh), 4u);
  expect_sound(mesh, 10, 1e-12);
}

TEST(Repair, OrientTurnsFacetsAndShells) {
  std::mt19937 random(5);
  SurfaceMesh mesh = tube_surface(0.5, 1, 3, 24);
  const double volume = check_surface(mesh, tolerance).volume;
  for (Triangle& t : mesh.triangles)
    if (random() % 2 == 0) std::swap(t[1], t[2]);
  mend(mesh, {RepairStep::orient});
  expect_sound(mesh, volume, 1e-12);
  SurfaceMesh hollow = box;
  append(hollow, inverted(box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75})));
  hollow = inverted(hollow);
  mend(hollow, {RepairStep::orient});
  EXPECT_EQ(check_surface(hollow, tolerance).cavities(), 1);
  expect_sound(hollow, 5.5, 1e-12);
}

TEST(Repair, ABodyWithinABodyIsNotMadeACavity) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75}));
  mend(mesh, {RepairStep::weld, RepairStep::orient});
  EXPECT_FALSE(check_surface(mesh, tolerance).sound());
}

TEST(Repair, KeepsTheGroupsOfFacets) {
  SurfaceMesh mesh = unwelded(box, 1e-4);
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.groups = {{"side", {10, 11}}, {"twice", {0, 12}}};
  mend(mesh, {RepairStep::weld});
  ASSERT_EQ(mesh.groups.size(), 2u);
  for (const int f : mesh.groups[0].facets)
    EXPECT_NEAR(mesh.area_vector(static_cast<std::size_t>(f)).normalized().x(), 1, 1e-3);
  EXPECT_EQ(mesh.groups[1].facets.size(), 1u);
}

TEST(Repair, WithoutItsHelperSaysSo) {
  SurfaceMesh mesh = box;
  mesh.triangles.pop_back();
  common::Progress silent;
  RepairOptions options;
  options.steps = {RepairStep::fill};
  options.helper = "/nonexistent/kinetostat-cgal";
  const RepairReport report = repair(mesh, options, silent);
  ASSERT_EQ(report.actions.size(), 1u);
  EXPECT_FALSE(report.actions[0].done);
  EXPECT_THAT(report.actions[0].words, HasSubstr("cannot be run"));
}

// Another step in its place would make the result depend on what else the machine does.
TEST(Repair, WhereMemoryRunsOutItEnds) {
  SurfaceMesh mesh = box;
  mesh.triangles.pop_back();
  common::Progress silent;
  const TemporaryFolder folder;
  RepairOptions options;
  options.steps = {RepairStep::fill, RepairStep::wrap};
  options.helper = folder.file("helper", "#!/bin/sh\nexit 65\n");
  std::filesystem::permissions(options.helper, std::filesystem::perms::owner_all);
  try {
    repair(mesh, options, silent);
    ADD_FAILURE() << "a repair out of nothing";
  } catch (const common::OutOfMemory& error) {
    EXPECT_THAT(error.what(), HasSubstr("the step 'fill' needs more memory than there is"));
  }
}

TEST(EnclosedVolume, CountsOverlapsOnceAndKnowsWhenItIsUndetermined) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({2, 0, 0}, {5, 2, 1}));
  EXPECT_NEAR(enclosed_volume(mesh).value(), 10, 0.1);
  SurfaceMesh open = box;
  open.triangles.resize(8);
  EXPECT_FALSE(enclosed_volume(open).has_value());
}

TEST(SurfaceDistance, IsThatOfTheFarthestPoint) {
  const SurfaceMesh inner = box_surface({0.1, 0.1, 0.1}, {2.9, 1.9, 0.7});
  const SurfaceLocator locator(box);
  EXPECT_NEAR(farthest_distance(inner, locator, 0.1), 0.3, 1e-12);
  EXPECT_NEAR(locator.nearest({1, 1, 4}).distance, 3, 1e-12);
  EXPECT_NEAR(locator.nearest({4, 3, 2}).distance, std::sqrt(3.0), 1e-12);
}

// A large facet over a surface with a dent: no corner of it is far, its middle is.
TEST(SurfaceDistance, FindsWhatIsFarBetweenTheCorners) {
  SurfaceMesh facet{.points = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}, .triangles = {{0, 1, 2}}};
  SurfaceMesh dented;
  constexpr int n = 20;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const Vector3 p(0.5 * i, 0.5 * j, 0);
      const double r = (p - Vector3(2.9, 3.3, 0)).norm();
      dented.points.emplace_back(p.x(), p.y(), r < 2 ? -0.4 * (2 - r) : 0);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int k = j * (n + 1) + i;
      dented.triangles.push_back({k, k + 1, k + n + 2});
      dented.triangles.push_back({k, k + n + 2, k + n + 1});
    }
  const SurfaceLocator locator(dented);
  double sampled = 0;
  constexpr int samples = 400;
  for (int i = 0; i <= samples; ++i)
    for (int j = 0; i + j <= samples; ++j)
      sampled =
          std::max(sampled, locator.nearest({10.0 * i / samples, 10.0 * j / samples, 0}).distance);
  ASSERT_GT(sampled, 0.3);
  const double found = farthest_distance(facet, locator, 0.01);
  EXPECT_GE(found, sampled - 0.01);
  EXPECT_LE(found, sampled + 0.025);  // half the distance of two samples
  EXPECT_NEAR(farthest_distance(dented, SurfaceLocator(dented), 0.1), 0, 1e-14);
}

TEST(Bodies, AreNamedByTheFileOrNumbered) {
  SurfaceMesh mesh = box;
  append(mesh, inverted(box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75})));
  append(mesh, box_surface({5, 0, 0}, {6, 1, 1}));
  const auto shells = nested_shells(mesh, edge_uses(mesh));
  std::vector<Body> bodies = find_bodies(mesh, shells);
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[0].name, "1");
  EXPECT_EQ(bodies[0].facets.size(), 24u);
  EXPECT_NEAR(bodies[0].volume, 5.5, 1e-12);
  mesh.groups = {{"case", bodies[0].facets}, {"lid", bodies[1].facets}};
  bodies = find_bodies(mesh, shells);
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[1].name, "lid");
  keep_body(mesh, bodies[1]);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.groups.size(), 1u);
}

#ifdef KINETOSTAT_CGAL
TEST(RepairByCgal, FillClosesAHoleFlat) {
  SurfaceMesh mesh = box;
  mesh.triangles.erase(mesh.triangles.begin() + 4, mesh.triangles.begin() + 6);
  const RepairReport report = mend(mesh, {RepairStep::fill});
  ASSERT_EQ(report.actions.size(), 1u);
  EXPECT_THAT(report.actions[0].words, HasSubstr("1 hole closed"));
  EXPECT_NEAR(report.patch_area, 3, 1e-9);
  expect_sound(mesh, 6, 1e-12);
}

TEST(RepairByCgal, UniteGivesTheExactUnion) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({2, 0.5, 0.25}, {5, 1.5, 0.75}));  // half a unit of volume within
  append(mesh, box_surface({0.5, 0.5, 0.25}, {1, 1, 0.75}));  // wholly within
  mend(mesh, {RepairStep::unite});
  expect_sound(mesh, 6 + 1, 1e-9);
}

// Two boxes with a face in common, each of which cuts it along a diagonal of its own.
TEST(RepairByCgal, UniteTakesBodiesThatShareAFace) {
  SurfaceMesh mesh = box_surface({0, 0, 0}, {1, 2, 1});
  SurfaceMesh other = box_surface({1, 0, 0}, {3, 2, 1});
  for (Vector3& point : other.points) point.y() = 2 - point.y();  // mirrored, and so turned over
  append(mesh, inverted(other));
  weld_open_edges(mesh, 1e-9);
  mend(mesh, {RepairStep::weld, RepairStep::unite});
  expect_sound(mesh, 6, 1e-9);
  EXPECT_EQ(check_surface(mesh, tolerance).bodies(), 1);
}

// Steps of a union that are thinner than what a file is welded by: what the file gives back is what
// was repaired, and was checked.
TEST(RepairByCgal, WhatIsWrittenIsWhatWasChecked) {
  const test::TemporaryFolder folder;
  for (const double step : {0.0, 1e-7, 1e-6, 2e-6, 3e-6, 5e-6}) {
    SurfaceMesh mesh = box;
    append(mesh, box_surface({1, 0.5, 0.5}, {2.1, 1.3, 1 + step}));
    common::Progress silent;
    RepairOptions options{.steps = {RepairStep::unite}, .stored_unit = 1e-3};
    options.helper = cgal_helper();
    repair(mesh, options, silent);
    EXPECT_TRUE(check_surface(mesh, weld_tolerance(mesh.points)).sound()) << step;
    io::write_atomically(folder.path() / "part.stl", stl_bytes(mesh, 1e-3));
    const SurfaceMesh read = read_surface(folder.path() / "part.stl", "mm").mesh;
    EXPECT_TRUE(check_surface(read, weld_tolerance(read.points)).sound()) << step;
    EXPECT_EQ(read.triangles.size(), mesh.triangles.size()) << step;
    EXPECT_EQ(read.points.size(), mesh.points.size()) << step;
  }
}

TEST(RepairByCgal, UniteKeepsCavities) {
  SurfaceMesh mesh = box;
  append(mesh, inverted(box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75})));
  append(mesh, box_surface({2.5, 0.5, 0.25}, {5, 1.5, 0.75}));
  mend(mesh, {RepairStep::unite});
  expect_sound(mesh, 5.5 + 1, 1e-9);
  EXPECT_EQ(check_surface(mesh, tolerance).cavities(), 1);
}

// The middle of an edge of the top is pulled out through the bottom.
TEST(RepairByCgal, UniteRepairsABodyThatCrossesItself) {
  SurfaceMesh mesh = fine_box();
  const auto pulled = std::find_if(mesh.points.begin(), mesh.points.end(), [](const Vector3& p) {
    return (p - Vector3(1.5, 0, 1)).norm() < 1e-9;
  });
  ASSERT_NE(pulled, mesh.points.end());
  *pulled = {1.5, 0.2, -0.1};
  ASSERT_FALSE(check_surface(mesh, tolerance).sound());
  const RepairReport report = mend(mesh, {RepairStep::unite}, 0.1);
  ASSERT_TRUE(report.actions.at(0).done) << report.actions[0].words;
  EXPECT_TRUE(check_surface(mesh, tolerance).sound());
}

// Screws that touch nothing but the part are united with it all at once.
TEST(RepairByCgal, UniteTakesManyPartsInFewSteps) {
  SurfaceMesh mesh = box_surface({0, 0, 0}, {40, 40, 1});
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      append(mesh, box_surface({3.0 * i + 2, 3.0 * j + 2, 0.5}, {3.0 * i + 3, 3.0 * j + 3, 1.5}));
  const RepairReport report = mend(mesh, {RepairStep::unite});
  ASSERT_TRUE(report.actions.at(0).done) << report.actions[0].words;
  expect_sound(mesh, 1600 + 144 * 0.5, 1e-9);
}

TEST(Repair, WeldTakesLooseSliversAway) {
  SurfaceMesh mesh = box;
  mesh.points.push_back(0.5 * (mesh.points[4] + mesh.points[5]));
  mesh.triangles.push_back({4, 5, 8});
  ASSERT_FALSE(check_surface(mesh, tolerance).sound());
  mend(mesh, {RepairStep::weld});
  expect_sound(mesh, 6, 1e-12);
}

// A sticker in a face, and a fin without thickness on an edge.
TEST(RepairByCgal, SheetsWithoutVolumeAreLeftOut) {
  SurfaceMesh mesh = box;
  append(mesh, {.points = {{0.5, 0.5, 1}, {1, 0.5, 1}, {1, 1, 1}}, .triangles = {{0, 1, 2}}});
  append(mesh, {.points = {{0, 0, 1}, {1, 0, 1}, {1, 0, 2}}, .triangles = {{0, 1, 2}}});
  const RepairReport report = mend(mesh, {RepairStep::fill});
  EXPECT_THAT(report.actions.at(0).words, HasSubstr("2 sheets without volume left out"));
  expect_sound(mesh, 6, 1e-9);
}

TEST(RepairByCgal, BodiesApartAreNotWrappedEither) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({5, 0, 0}, {8, 2, 1}));
  const RepairReport report = mend(mesh, {RepairStep::wrap}, 0.05);
  EXPECT_THAT(report.actions.at(0).words, HasSubstr("2 bodies would be left"));
  EXPECT_EQ(mesh.triangles.size(), 24u);
}

TEST(RepairByCgal, BodiesApartAreNotUnited) {
  SurfaceMesh mesh = box;
  append(mesh, box_surface({5, 0, 0}, {6, 1, 1}));
  const RepairReport report = mend(mesh, {RepairStep::unite});
  EXPECT_THAT(report.actions.at(0).words, HasSubstr("do not touch"));
  EXPECT_EQ(check_surface(mesh, tolerance).bodies(), 2);
}

TEST(RepairByCgal, WrapStaysNearAndIsGivenUpBeyondTheLimit) {
  SurfaceMesh twisted = tube_surface(0.5, 1, 3, 24);
  append(twisted, box_surface({0.7, -0.1, 1}, {2, 0.1, 2}));
  SurfaceMesh mesh = twisted;
  const RepairReport report = mend(mesh, {RepairStep::wrap}, 0.05);
  ASSERT_TRUE(report.actions.at(0).done) << report.actions[0].words;
  const double diagonal = bounding_box(twisted.points).diagonal().norm();
  EXPECT_LT(report.distance, 0.05 * diagonal);
  EXPECT_NEAR(report.volume_after / *report.volume_before, 1, 0.05);
  EXPECT_TRUE(check_surface(mesh, tolerance).sound());
  mesh = twisted;
  EXPECT_FALSE(mend(mesh, {RepairStep::wrap}, 1e-5).actions.at(0).done);
  EXPECT_EQ(mesh.triangles, twisted.triangles);
}

TEST(RepairByCgal, ASheetIsNotWrappedIntoAThinShell) {
  SurfaceMesh mesh = box;
  mesh.triangles.resize(2);
  const RepairReport report = mend(mesh, {RepairStep::wrap});
  EXPECT_FALSE(report.actions.at(0).done);
  EXPECT_THAT(report.actions[0].words, HasSubstr("open"));
}

TEST(RepairByCgal, GivesTheSameSurfaceTwice) {
  const auto wrapped = [] {
    SurfaceMesh mesh = tube_surface(0.5, 1, 3, 24);
    append(mesh, box_surface({0.7, -0.1, 1}, {2, 0.1, 2}));
    mend(mesh, {RepairStep::wrap}, 0.05);
    return mesh;
  };
  const SurfaceMesh one = wrapped(), other = wrapped();
  EXPECT_EQ(one.triangles, other.triangles);
  EXPECT_EQ(one.points, other.points);
}
#endif

}  // namespace
}  // namespace kinetostat::fea::surface_repair_test
