#include "kinetostat/fea/mesh/tetrahedralize.h"

#include <chrono>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fea/shapes.h"

namespace kinetostat::fea::tetrahedralize_test {
namespace {

using Cause = MeshingError::Cause;

TetrahedralizeOptions with_size(double edge) {
  TetrahedralizeOptions options;
  options.edge_length = edge;
  options.helper = KINETOSTAT_TETGEN;
  return options;
}

TetMesh meshed(const SurfaceMesh& surface, double edge, std::vector<int> tags = {}) {
  common::Progress silent;
  tags.resize(surface.triangles.size(), 0);
  return tetrahedralize(surface, tags, with_size(edge), silent);
}

std::map<int, double> area_of_tags(const TetMesh& mesh) {
  std::map<int, double> area;
  for (const BoundaryFace& face : mesh.boundary) {
    const auto p = [&](std::size_t k) {
      return mesh.nodes[static_cast<std::size_t>(face.nodes[k])];
    };
    area[face.tag] += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
  }
  return area;
}

void expect_positive_elements(const TetMesh& mesh) {
  for (std::size_t e = 0; e < mesh.element_count(); ++e) EXPECT_GT(volume(mesh.corners(e)), 0) << e;
}

TEST(Tetrahedralize, FillsABoxAndCarriesItsTags) {
  std::vector<int> tags(12, 0);
  tags[8] = tags[9] = 1;    // x = 0
  tags[10] = tags[11] = 2;  // x = 0.31
  const TetMesh mesh = meshed(box_surface({0, 0, 0}, {0.31, 0.02, 0.012}), 0.005, tags);
  expect_positive_elements(mesh);
  EXPECT_NEAR(mass_properties(mesh).volume, 0.31 * 0.02 * 0.012, 1e-16);
  const auto area = area_of_tags(mesh);
  EXPECT_NEAR(area.at(1), 0.02 * 0.012, 1e-16);
  EXPECT_NEAR(area.at(2), 0.02 * 0.012, 1e-16);
  EXPECT_GT(quality(mesh).least_dihedral, 10);
  const double largest = 0.005 * 0.005 * 0.005 / (6 * std::sqrt(2.0));
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    EXPECT_LT(volume(mesh.corners(e)), 1.3 * largest);  // its last smoothing may exceed it a little
}

TEST(Tetrahedralize, BoundaryFacesLookOutwards) {
  const TetMesh mesh = meshed(box_surface({-1, -1, -1}, {1, 1, 1}), 0.5);
  Vector3 sum = Vector3::Zero();
  for (const BoundaryFace& face : mesh.boundary) {
    const auto p = [&](std::size_t k) {
      return mesh.nodes[static_cast<std::size_t>(face.nodes[k])];
    };
    const Vector3 area = (p(1) - p(0)).cross(p(2) - p(0));
    EXPECT_GT(area.dot(p(0) + p(1) + p(2)), 0);
    sum += area;
  }
  EXPECT_NEAR(sum.norm(), 0, 1e-13);
}

TEST(Tetrahedralize, LeavesCavitiesEmpty) {
  SurfaceMesh surface = box_surface({0, 0, 0}, {3, 2, 1});
  append(surface, inverted(box_surface({0.5, 0.5, 0.25}, {1, 1.5, 0.75})));
  append(surface, inverted(tube_surface(0.1, 0.3, 0.4, 12)));
  for (std::size_t i = 16; i < surface.points.size(); ++i) surface.points[i] += Vector3(2, 1, 0.3);
  const SurfaceReport report = check_surface(surface, 1e-6);
  ASSERT_TRUE(report.sound());
  const TetMesh mesh = meshed(surface, 0.3);
  EXPECT_NEAR(mass_properties(mesh).volume, report.volume, 1e-12);
}

TEST(Tetrahedralize, ABoreAndAThinWallKeepTheirVolume) {
  for (const double inner : {0.5, 0.98}) {
    const SurfaceMesh surface = tube_surface(inner, 1, 3, 48);
    const double expected = check_surface(surface, 1e-6).volume;
    const TetMesh mesh = meshed(surface, 0.4);
    expect_positive_elements(mesh);
    EXPECT_NEAR(mass_properties(mesh).volume, expected, 1e-10 * expected);
    EXPECT_EQ(count_pieces(mesh), 1);
  }
}

TEST(Tetrahedralize, WorksFarFromTheOriginAndAtAnyScale) {
  for (const double scale : {1e-4, 1.0, 1e3}) {
    SurfaceMesh surface = box_surface({0, 0, 0}, {3, 2, 1});
    for (Vector3& p : surface.points) p = scale * (p + Vector3(100, -200, 50));
    const TetMesh mesh = meshed(surface, 0.5 * scale);
    EXPECT_NEAR(mass_properties(mesh).volume / std::pow(scale, 3), 6, 1e-9);
  }
}

TEST(Tetrahedralize, TheSameInputGivesTheSameMesh) {
  const SurfaceMesh surface = tube_surface(0.5, 1, 3, 24);
  const TetMesh a = meshed(surface, 0.3), b = meshed(surface, 0.3);
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.connectivity, b.connectivity);
}

MeshingError failure_of(const SurfaceMesh& surface, const TetrahedralizeOptions& options) {
  common::Progress silent;
  try {
    tetrahedralize(surface, std::vector<int>(surface.triangles.size(), 0), options, silent);
  } catch (const MeshingError& error) {
    return error;
  }
  throw std::logic_error("meshing did not fail");
}

// Our own check finds these before TetGen sees them; here TetGen meets them all the same.
TEST(Tetrahedralize, NamesTheFacetsOnWhichTetGenFails) {
  SurfaceMesh surface = box_surface({0, 0, 0}, {310, 20, 12});
  append(surface, box_surface({100.3, 5.1, -10}, {200.3, 15.1, 30}));
  const MeshingError error = failure_of(surface, with_size(20));
  EXPECT_THAT(error.facets(), testing::Contains(0));
  EXPECT_THAT(error.facets(), testing::Contains(testing::Gt(11)));
  EXPECT_THAT(error.cure(), testing::HasSubstr("mesh check"));
}

class FakeHelper : public testing::Test {
 protected:
  TetrahedralizeOptions options_for(const std::string& script) {
    TetrahedralizeOptions options = with_size(0.5);
    options.helper = folder_.file("helper", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(options.helper, std::filesystem::perms::owner_all);
    options.time_limit = 2;
    return options;
  }
  const SurfaceMesh surface_ = box_surface({0, 0, 0}, {3, 2, 1});
  TemporaryFolder folder_;
};

TEST_F(FakeHelper, ThatHangsIsStopped) {
  const auto start = std::chrono::steady_clock::now();
  const MeshingError error = failure_of(surface_, options_for("exec sleep 600"));
  EXPECT_EQ(error.cause(), Cause::timed_out);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST_F(FakeHelper, ThatCrashesIsAnErrorOfItsInput) {
  const MeshingError error = failure_of(surface_, options_for("kill -SEGV $$"));
  EXPECT_EQ(error.cause(), Cause::crashed);
  EXPECT_THAT(error.what(), testing::HasSubstr("crashed"));
}

TEST_F(FakeHelper, ThatRefusesNamesTheFacetsItPrints) {
  const MeshingError error = failure_of(
      surface_, options_for("echo 'Facet #1 intersects facet #2 at triangles:'; "
                            "echo ' (   0,    2,    3) and (   5,    7,    4)'; exit 73"));
  EXPECT_EQ(error.cause(), Cause::refused);
  EXPECT_EQ(error.facets(), (std::vector<int>{0, 2}));
  EXPECT_THAT(error.what(), testing::HasSubstr("1, 3"));
}

TEST_F(FakeHelper, ThatAnswersNonsenseIsNotBelieved) {
  EXPECT_EQ(failure_of(surface_, options_for("echo garbage >&3; exit 0")).cause(), Cause::crashed);
  EXPECT_EQ(failure_of(surface_, options_for("exit 0")).cause(), Cause::crashed);
}

TEST_F(FakeHelper, ThatRunsOutOfMemoryIsSaidToHave) {
  EXPECT_EQ(failure_of(surface_, options_for("exit 65")).cause(), Cause::out_of_memory);
}

TEST_F(FakeHelper, ThatIsNotThereIsMissed) {
  TetrahedralizeOptions options = with_size(0.5);
  options.helper = folder_.path() / "absent";
  EXPECT_EQ(failure_of(surface_, options).cause(), Cause::no_helper);
}

TEST_F(FakeHelper, IsStoppedWhenTheUserCancels) {
  class CancelledProgress : public common::Progress {
    bool cancelled() const override { return true; }
  } cancelled;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(
      tetrahedralize(surface_, std::vector<int>(12, 0), options_for("exec sleep 600"), cancelled),
      common::Cancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(Tetrahedralize, MemoryIsLimited) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer needs all address space";
#endif
  TetrahedralizeOptions options = with_size(0.02);
  options.memory_limit = std::size_t{100} << 20;
  const MeshingError error = failure_of(box_surface({0, 0, 0}, {3, 2, 1}), options);
  EXPECT_EQ(error.cause(), Cause::out_of_memory);
}

TEST(Tetrahedralize, AnAbsurdSizeIsRefusedBeforehandWithOneThatWorks) {
  const SurfaceMesh surface = box_surface({0, 0, 0}, {3, 2, 1});
  const MeshingError error = failure_of(surface, with_size(1e-4));
  EXPECT_EQ(error.cause(), Cause::too_many_elements);
  EXPECT_THAT(error.cure(), testing::HasSubstr("Use a size of"));
}

}  // namespace
}  // namespace kinetostat::fea::tetrahedralize_test
