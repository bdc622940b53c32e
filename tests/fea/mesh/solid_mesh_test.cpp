#include "kinetostat/fea/mesh/solid_mesh.h"

#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/mesh/flat_elements.h"
#include "kinetostat/fea/surface/surface_check.h"
#include "kinetostat/fea/surface/surface_distance.h"

#include "fea/shapes.h"
#include "fea/surface/hard_surfaces.h"

namespace kinetostat::fea::solid_mesh_test {
namespace {

constexpr double mm = 1e-3;

struct Part {
  SurfaceMesh surface;
  std::vector<int> tags;
};

// As `identify` reads it: in metres, welded, the ends in x tagged 1 and 2.
Part part_of(const std::string& family, int variant) {
  const hard::HardSurface hard = hard::hard_surface(family, variant);
  Part part{.surface = hard.mesh, .tags = {}};
  for (Vector3& p : part.surface.points) p *= mm;
  weld(part.surface, weld_tolerance(part.surface.points));
  for (std::size_t f = 0; f < part.surface.triangles.size(); ++f) {
    const auto lies_in = [&](const Box& box) {
      for (std::size_t k = 0; k < 3; ++k)
        if (!box.contains(part.surface.corner(f, k) / mm)) return false;
      return true;
    };
    part.tags.push_back(lies_in(hard.fixed) ? 1 : lies_in(hard.loaded) ? 2 : 0);
  }
  return part;
}

TetrahedralizeOptions within(double seconds) {
  TetrahedralizeOptions options;
  options.time_limit = seconds;
  options.helper = KINETOSTAT_TETGEN;
#ifdef KINETOSTAT_CGAL
  options.remesher = KINETOSTAT_CGAL;
#endif
  return options;
}

double tagged_area(const TetMesh& mesh, int tag) {
  double area = 0;
  for (const BoundaryFace& face : mesh.boundary) {
    const auto p = [&](std::size_t k) {
      return mesh.nodes[static_cast<std::size_t>(face.nodes[k])];
    };
    if (face.tag == tag) area += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
  }
  return area;
}

double tagged_area(const Part& part, int tag) {
  double area = 0;
  for (std::size_t f = 0; f < part.tags.size(); ++f)
    if (part.tags[f] == tag) area += part.surface.area_vector(f).norm();
  return area;
}

// The mesh fills the part, as far as the record says that it does.
void expect_filled(const TetMesh& mesh, const Part& part, const MeshingRecord& record) {
  EXPECT_FALSE(has_flat_elements(mesh));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) ASSERT_GT(volume(mesh.corners(e)), 0);
  const double change = mass_properties(mesh).volume / mass_properties(part.surface).volume - 1;
  if (!record.deviation) {
    EXPECT_NEAR(change, 0, 2e-5);
  } else {
    EXPECT_NEAR(change, record.deviation->volume_change, 2e-5);
    EXPECT_LE(std::abs(change), most_volume_change);
    EXPECT_LE(record.deviation->distance, record.deviation->allowed);
    const SurfaceLocator given(part.surface);
    double farthest = 0;
    for (const BoundaryFace& face : mesh.boundary)
      for (std::size_t k = 0; k < 3; ++k)
        farthest = std::max(
            farthest, given.nearest(mesh.nodes[static_cast<std::size_t>(face.nodes[k])]).distance);
    EXPECT_LE(farthest, record.deviation->allowed);
  }
  for (const int tag : {1, 2})
    EXPECT_NEAR(tagged_area(mesh, tag), tagged_area(part, tag), 0.02 * tagged_area(part, tag));
}

struct HardCase {
  const char* family;
  int variant;
};

class HardSurfaces : public testing::TestWithParam<HardCase> {};

// The others are run by scripts/hard-meshes.
TEST_P(HardSurfaces, AreFilled) {
  const auto [family, variant] = GetParam();
  const Part part = part_of(family, variant);
  ASSERT_TRUE(check_surface(part.surface, weld_tolerance(part.surface.points)).sound());
  SolidMesher mesher(part.surface, part.tags);
  common::Progress silent;
  const TetMesh mesh = mesher.fill(within(120), silent);
  expect_filled(mesh, part, mesher.record());
}

INSTANTIATE_TEST_SUITE_P(SolidMesh, HardSurfaces,
                         testing::Values(HardCase{"hollow_shell", 5}, HardCase{"slivers", 2},
                                         HardCase{"slivers", 4}, HardCase{"thin_wall", 4},
                                         HardCase{"coplanar_overlap", 1},
                                         HardCase{"small_components", 1}, HardCase{"needles", 2},
                                         HardCase{"flat_noise", 4}, HardCase{"cad_part", 2},
                                         HardCase{"decimated_cover", 2}, HardCase{"sharp_edge", 5}),
                         [](const auto& part) {
                           return fmt::format("{}_{}", part.param.family, part.param.variant);
                         });

TEST(SolidMesh, AllHardSurfacesCalledSoundAreSound) {
  for (const std::string& family : hard::families())
    for (int variant = 0; variant < hard::variants; ++variant) {
      if (hard::hard_surface(family, variant).is_broken) break;
      const Part part = part_of(family, variant);
      EXPECT_TRUE(check_surface(part.surface, weld_tolerance(part.surface.points)).sound())
          << family << '_' << variant;
    }
}

TEST(SolidMesh, LaterMeshesStartWhereTheFirstWasMade) {
  const Part part = part_of("sharp_edge", 3);
  SolidMesher mesher(part.surface, part.tags);
  common::Progress silent;
  TetrahedralizeOptions options = within(120);
  const TetMesh first = mesher.fill(options, silent);
  const MeshingRecord record = mesher.record();
  ASSERT_FALSE(record.failures.empty());
  const double elements = 2 * static_cast<double>(first.element_count());
  options.edge_length = std::cbrt(6 * std::sqrt(2.0) * mass_properties(first).volume / elements);
  const TetMesh second = mesher.fill(options, silent);
  EXPECT_EQ(mesher.record().way, record.way);
  EXPECT_EQ(mesher.record().failures.size(), record.failures.size());
  EXPECT_GT(second.element_count(), first.element_count());
  expect_filled(second, part, mesher.record());
}

// Where facets are narrow TetGen may make a thousand times the elements that were wished for.
TEST(SolidMesh, AMeshOfFarTooManyElementsIsNone) {
  const Part part = part_of("sharp_edge", 3);
  SolidMesher mesher(part.surface, part.tags);
  common::Progress silent;
  TetrahedralizeOptions options = within(120);
  const std::size_t first = mesher.fill(options, silent).element_count();
  const std::size_t failures = mesher.record().failures.size();
  options.most_elements = first / 2;
  try {
    EXPECT_LE(mesher.fill(options, silent).element_count(), first / 2);
  } catch (const MeshingError&) {  // no rung makes so few
  }
  ASSERT_GT(mesher.record().failures.size(), failures);
  EXPECT_THAT(mesher.record().failures[failures].reason,
              testing::HasSubstr(std::to_string(first) + " elements are far more"));
}

// Every rung has its share, and all of them together no more than the limit.
TEST(SolidMesh, TheLimitHoldsForAllAttemptsTogether) {
  const Part part = part_of("slivers", 3);
  SolidMesher mesher(part.surface, part.tags);
  common::Progress silent;
  const auto begin = std::chrono::steady_clock::now();
  try {
    mesher.fill(within(1), silent);
  } catch (const MeshingError& error) {
    EXPECT_GT(mesher.record().failures.size(), 10u);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(took.count(), 15);
}

TEST(SolidMesh, TheLimitHoldsForAllMeshesTogether) {
  const SurfaceMesh box = box_surface({0, 0, 0}, {1, 1, 1});
  const std::vector<int> tags(box.triangles.size(), 0);
  SolidMesher mesher(box, tags);
  common::Progress silent;
  mesher.fill(within(60), silent);
  try {
    mesher.fill(within(1e-6), silent);
    FAIL() << "the time was used up";
  } catch (const MeshingError& error) {
    EXPECT_EQ(error.cause(), MeshingError::Cause::timed_out);
    EXPECT_THAT(error.cure(), testing::HasSubstr("--mesh-time"));
  }
}

// A failure names the first reason and what else was tried.
TEST(SolidMesh, WithoutCgalTheOtherRungsAreTried) {
  const Part part = part_of("slivers", 2);
  SolidMesher mesher(part.surface, part.tags);
  common::Progress silent;
  TetrahedralizeOptions options = within(60);
  options.remesher = "/nowhere/kinetostat-cgal";
  try {
    const TetMesh mesh = mesher.fill(options, silent);
    expect_filled(mesh, part, mesher.record());
  } catch (const MeshingError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("remeshed"));
    EXPECT_THAT(error.what(), testing::HasSubstr("gmsh"));
  }
  for (const MeshingFailure& failure : mesher.record().failures)
    EXPECT_FALSE(failure.reason.empty()) << failure.way;
}

}  // namespace
}  // namespace kinetostat::fea::solid_mesh_test
