#include "kinetostat/fea/surface/step_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/interface/interface_selection.h"
#include "kinetostat/fea/mesh/mesh_check.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/io/text_file.h"

#include "fea/surface/step_parts.h"
#include "support/temporary_folder.h"

namespace kinetostat::fea::step_program_test {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;

std::string text_of(const std::filesystem::path& file) { return io::read_text(file); }

TEST(StepProgram, CutsFacesAsFinelyAsAskedAndDescribesThem) {
  const TemporaryFolder folder;
  test::write_round_bar(folder.path() / "bar.step", 40, 200);
  common::Progress silent;
  const SurfaceMesh bar =
      step_surface(text_of(folder.path() / "bar.step"), {.sides = 24, .deviation = 1}, {}, silent);
  ASSERT_EQ(bar.faces.size(), 3u);
  std::set<std::string> names;
  for (const CadFace& face : bar.faces) {
    names.insert(face.name);
    EXPECT_EQ(face.solid, 1);
    if (face.kind == FaceKind::cylinder) {
      EXPECT_NEAR(face.radius, 0.02, 1e-12);
      EXPECT_NEAR(face.area, std::numbers::pi * 0.04 * 0.2, 1e-9);
      EXPECT_NEAR(std::abs(face.direction.x()), 1, 1e-12);
    } else {
      EXPECT_EQ(face.kind, FaceKind::plane);
      EXPECT_NEAR(face.direction.x(), face.name == "head" ? 1 : -1, 1e-12);
    }
  }
  EXPECT_EQ(names, (std::set<std::string>{"", "foot", "head"}));
  SurfaceMesh welded = bar;
  weld(welded, weld_tolerance(welded.points));
  const SurfaceReport report = check_surface(welded, weld_tolerance(welded.points));
  EXPECT_TRUE(report.sound());
  // At least as much as a prism of 24 sides, and less than a cylinder.
  EXPECT_GT(report.volume, 0.2 * 12 * 0.02 * 0.02 * std::sin(std::numbers::pi / 12) - 1e-12);
  EXPECT_LT(report.volume, 0.2 * std::numbers::pi * 0.02 * 0.02);
}

TEST(StepProgram, FindsNearestPointsOnFacesEdgesAndCorners) {
  const TemporaryFolder folder;
  test::write_bored_block(folder.path() / "block.step", 20);
  const std::string step = text_of(folder.path() / "block.step");
  common::Progress silent;
  const SurfaceMesh block = step_surface(step, {}, {}, silent);
  const auto number = [&](auto is) {
    const auto at = std::find_if(block.faces.begin(), block.faces.end(), is);
    return static_cast<int>(at - block.faces.begin()) + 1;
  };
  const auto side = [&](const Vector3& normal) {
    return number([&](const CadFace& f) {
      return f.kind == FaceKind::plane && (f.direction - normal).norm() < 1e-9;
    });
  };
  const int bore = number([](const CadFace& f) { return f.kind == FaceKind::cylinder; });
  const int top = side({0, 0, 1}), right = side({1, 0, 0}), back = side({0, 1, 0});
  PointsOnFaces asked;
  asked.points = {{0.006, 0.006, 0.003}, {0.012, 0, 0.009}, {0.028, 0.027, 0.009}, {1, 2, 3}};
  asked.faces = {{bore}, {std::min(bore, top), std::max(bore, top)}, {top, right, back}, {}};
  std::sort(asked.faces[2].begin(), asked.faces[2].end());
  const std::vector<Vector3> found = nearest_on_faces(step, asked, {}, silent);
  const double half = 0.01 / std::numbers::sqrt2;
  EXPECT_LT((found[0] - Vector3(half, half, 0.003)).norm(), 1e-9);
  EXPECT_LT((found[1] - Vector3(0.01, 0, 0.01)).norm(), 1e-9);
  EXPECT_LT((found[2] - Vector3(0.03, 0.03, 0.01)).norm(), 1e-9);
  EXPECT_LT((found[3] - Vector3(1, 2, 3)).norm(), 1e-12);
}

TEST(StepProgram, LengthsAreThoseOfTheFileWhateverIsSaid) {
  const TemporaryFolder folder;
  test::write_bored_block(folder.path() / "block.step", 20);
  EXPECT_EQ(unit_of_format(folder.path() / "block.step"), "mm");
  for (const char* unit : {"", "mm", "inch"}) {
    const SurfaceMesh mesh = read_surface(folder.path() / "block.step", unit).mesh;
    EXPECT_NEAR(bounding_box(mesh.points).sizes().maxCoeff(), 0.06, 1e-12);
  }
}

TEST(StepProgram, SaysWhatIsWrong) {
  common::Progress silent;
  const auto cause_of = [&](const std::string& bytes, const StepLimits& limits) {
    try {
      step_surface(bytes, {}, limits, silent);
    } catch (const StepError& error) {
      return error.cause();
    }
    throw std::logic_error("it was read");
  };
  EXPECT_EQ(cause_of("ISO-10303-21;\nnonsense", {}), StepError::Cause::unreadable);
  EXPECT_EQ(cause_of("ISO-10303-21;", {.helper = "/nowhere/kinetostat-step"}),
            StepError::Cause::no_helper);
}

// The facets of a selection, as area and centroid.
struct Picked {
  double area = 0;
  Vector3 centroid = Vector3::Zero();
};
Picked picked(const SurfaceMesh& surface, const Selector& selector) {
  Picked result;
  for (const int facet : select_facets(surface, selector)) {
    const auto f = static_cast<std::size_t>(facet);
    const double area = surface.area_vector(f).norm();
    result.area += area;
    result.centroid += area * surface.centroid(f);
  }
  result.centroid /= result.area;
  return result;
}

TEST(CadFaces, NamesAndColoursSurviveAChangedDimension) {
  const TemporaryFolder folder;
  for (const double length : {360.0, 540.0}) {
    test::write_perforated_plate(folder.path() / "plate.step", length);
    const SurfaceMesh plate = read_surface(folder.path() / "plate.step", "mm", {.sides = 64}).mesh;
    ASSERT_EQ(plate.faces.size(), 40u);
    const double pitch = 1e-3 * length / 18;
    for (const int i : {1, 9, 17}) {
      const Picked bore = picked(plate, CadFaceSelector{.name = fmt::format("bore {}.2", i)});
      EXPECT_LT((bore.centroid - Vector3(i * pitch, 0.04, 0.005)).norm(), 1e-6) << i;
      EXPECT_NEAR(bore.area, std::numbers::pi * 0.006 * 0.01, 1e-3 * bore.area);
    }
    EXPECT_NEAR(picked(plate, CadFaceSelector{.name = "right"}).centroid.x(), 1e-3 * length, 1e-9);
    EXPECT_NEAR(picked(plate, CadFaceSelector{.name = "left"}).area, 0.06 * 0.01, 1e-12);
    EXPECT_LT((picked(plate, ColourSelector{"#ff0000"}).centroid - Vector3(9 * pitch, 0.04, 0.005))
                  .norm(),
              1e-6);
    for (std::size_t f = 0; f < plate.faces.size(); ++f) {
      const CadFace& face = plate.faces[f];
      const Picked by_number = picked(plate, CadFaceSelector{.number = static_cast<int>(f) + 1});
      EXPECT_NEAR(by_number.area, face.area, 2e-3 * face.area) << f;
      EXPECT_LT((by_number.centroid - face.centre).norm(), 1e-4) << f;
    }
  }
}

TEST(CadFaces, MissedOnesAreExplained) {
  const TemporaryFolder folder;
  test::write_round_bar(folder.path() / "bar.step", 40, 200);
  const SurfaceMesh bar = read_surface(folder.path() / "bar.step", "mm").mesh;
  EXPECT_TRUE(select_facets(bar, CadFaceSelector{.name = "haed"}).empty());
  EXPECT_THAT(nearest_candidates(bar, CadFaceSelector{.name = "haed"}, "mm"),
              HasSubstr("Did you mean 'head'? The faces are 1 to 3"));
  EXPECT_TRUE(select_facets(bar, CadFaceSelector{.number = 4}).empty());
  EXPECT_THAT(nearest_candidates(bar, CadFaceSelector{.number = 4}, "mm"),
              HasSubstr("The faces are 1 to 3"));
  EXPECT_TRUE(select_facets(bar, ColourSelector{"#00ff00"}).empty());
  EXPECT_THAT(nearest_candidates(bar, ColourSelector{"#00ff00"}, "mm"),
              HasSubstr("The colours of its faces: #"));
}

}  // namespace
}  // namespace kinetostat::fea::step_program_test
