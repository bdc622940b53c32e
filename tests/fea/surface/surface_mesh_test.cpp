#include "kinetostat/fea/surface/surface_mesh.h"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <limits>
#include <stdexcept>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/child_process.h"
#include "kinetostat/common/error.h"
#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/io/text_file.h"

#include "fea/shapes.h"

namespace kinetostat::fea::surface_mesh_test {
namespace {

using common::InputError;
using testing::HasSubstr;

const SurfaceMesh box = box_surface({0, 0, 0}, {0.31, 0.02, 0.012});

std::string message_of(const std::filesystem::path& file, const std::string& unit) {
  try {
    read_surface(file, unit);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ReadSurface, BinaryAndAsciiStlGiveTheSameWeldedBox) {
  const TemporaryFolder folder;
  for (const auto& file :
       {folder.file("a.stl", ascii_stl(box, 1000)), folder.file("b.STL", binary_stl(box, 1000))}) {
    const ImportedSurface surface = read_surface(file, "mm");
    EXPECT_EQ(surface.mesh.points.size(), 8u);
    EXPECT_EQ(surface.mesh.triangles.size(), 12u);
    EXPECT_EQ(surface.weld.points_before, 36u);
    EXPECT_TRUE(surface.weld.collapsed.empty());
    EXPECT_EQ(surface.sha256, io::sha256(io::read_text(file)));
    const Box bounds = bounding_box(surface.mesh.points);
    EXPECT_NEAR((bounds.sizes() - Vector3(0.31, 0.02, 0.012)).norm(), 0, 1e-8);
  }
}

// What editors and exporters leave around the text, and in names.
TEST(ReadSurface, ReadsOddAsciiStl) {
  const TemporaryFolder folder;
  const std::string text = ascii_stl(box, 1000);
  const std::size_t name = std::string("solid").size();
  ASSERT_TRUE(text.starts_with("solid"));
  std::string old_lines = text, capitals = text;
  std::replace(old_lines.begin(), old_lines.end(), '\n', '\r');
  std::transform(capitals.begin(), capitals.end(), capitals.begin(),
                 [](unsigned char c) { return std::toupper(c); });
  const std::string odd[] = {"\xef\xbb\xbf" + text,
                             "\n \r\n" + text,
                             text + std::string("\n\0\0", 3),
                             old_lines,
                             capitals,
                             "solid facet endfacet vertex" + text.substr(name),
                             "solid " + std::string(5000, 'x') + text.substr(name)};
  for (const std::string& content : odd) {
    const ImportedSurface surface = read_surface(folder.file("odd.stl", content), "mm");
    EXPECT_EQ(surface.mesh.triangles.size(), 12u) << content.substr(0, 30);
    EXPECT_EQ(surface.mesh.points.size(), 8u) << content.substr(0, 30);
  }
}

TEST(ReadSurface, SaysWhatLiesInPlaceOfAMesh) {
  const TemporaryFolder folder;
  EXPECT_THAT(
      message_of(folder.file("a.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n"),
                 "mm"),
      HasSubstr("git lfs pull"));
  EXPECT_THAT(message_of(folder.file("b.stl", "<?xml version=\"1.0\"?>\n" + std::string(500, ' ') +
                                                  "<COLLADA/>"),
                         "mm"),
              HasSubstr("starts with '<?xml version=\"1.0\"?>', not with 'solid'"));
  EXPECT_THAT(message_of(folder.file("c.x3d", "<X3D/>"), "mm"),
              HasSubstr("'.x3d' is not a surface format"));
}

TEST(ReadSurface, ReadsObjAndPly) {
  const TemporaryFolder folder;
  const auto obj = folder.file("t.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_EQ(read_surface(obj, "m").mesh.triangles.size(), 2u);
  const auto ply = folder.file(
      "t.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_EQ(read_surface(ply, "m").mesh.triangles.size(), 1u);
}

// A tetrahedron in centimetres, twice as large and moved by its node, with z up.
TEST(ReadSurface, ReadsColladaInItsOwnUnitWithItsNodes) {
  const TemporaryFolder folder;
  const std::string source =
      "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
      "version=\"1.4.1\"><asset><unit meter=\"0.01\" name=\"centimeter\"/><up_axis>Z_UP</up_axis>"
      "</asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array "
      "id=\"pa\" count=\"12\">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor "
      "source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
      "type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
      "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles "
      "count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 0 3 2 1 2 "
      "3</p></triangles></mesh></geometry></"
      "library_geometries><library_visual_scenes><visual_scene "
      "id=\"s\"><node id=\"n\"><matrix>2 0 0 10 0 2 0 20 0 0 2 30 0 0 0 "
      "1</matrix><instance_geometry "
      "url=\"#g\"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene "
      "url=\"#s\"/></scene></COLLADA>\n";
  const SurfaceMesh mesh = read_surface(folder.file("part.dae", source), "").mesh;
  EXPECT_EQ(mesh.points.size(), 4u);
  const Box extent = bounding_box(mesh.points);
  EXPECT_LT((extent.min() - Vector3(0.1, 0.2, 0.3)).norm(), 1e-7);
  EXPECT_LT((extent.max() - Vector3(0.12, 0.22, 0.32)).norm(), 1e-7);
}

TEST(ReadSurface, AMissingUnitIsRefusedWithTheSizesToChooseBy) {
  const TemporaryFolder folder;
  const auto file = folder.file("box.stl", binary_stl(box, 1000));
  const std::string message = message_of(file, "");
  EXPECT_THAT(message, HasSubstr("0.31 x 0.02 x 0.012 m in mm"));
  EXPECT_THAT(message, HasSubstr("310 x 20 x 12 m in m"));
  EXPECT_THAT(message, HasSubstr("7.874 x 0.508 x 0.3048 m in inch"));
  EXPECT_THAT(message_of(file, "kg"), HasSubstr("kg"));
}

TEST(ReadSurface, RefusesFilesThatAreCutShortOrNoMeshAtAll) {
  const TemporaryFolder folder;
  const std::string whole = binary_stl(box, 1000), text = ascii_stl(box, 1000);
  EXPECT_THAT(message_of(folder.file("1.stl", whole.substr(0, 300)), "mm"),
              HasSubstr("announces 12 facets"));
  EXPECT_THAT(message_of(folder.file("2.stl", whole.substr(0, 40)), "mm"), HasSubstr("too few"));
  EXPECT_THAT(message_of(folder.file("3.stl", text.substr(0, text.size() / 2)), "mm"),
              HasSubstr("cut short"));
  EXPECT_THAT(message_of(folder.file("4.stl", ""), "mm"), HasSubstr("empty"));
  EXPECT_THAT(message_of(folder.file("5.stl", std::string(84, '\0')), "mm"),
              HasSubstr("no facets"));
  EXPECT_THAT(message_of(folder.file("6.stl", std::string(5000, 'x')), "mm"), HasSubstr("STL"));
  EXPECT_THAT(message_of(folder.file("7.dwg", "AC1032"), "mm"),
              HasSubstr("Export the link as STL, OBJ, PLY, DAE or STEP"));
  EXPECT_THAT(message_of(folder.path() / "absent.stl", "mm"), HasSubstr("absent.stl"));
}

TEST(ReadSurface, NeverCrashesOnDamagedFiles) {
  const TemporaryFolder folder;
  const std::string sources[] = {
      ascii_stl(box, 1000), binary_stl(box, 1000),
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1//1 2//7 9999\n",
      "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0123"};
  const char* names[] = {"a.stl", "b.stl", "c.obj", "d.ply"};
  unsigned state = 1;
  for (std::size_t s = 0; s < 4; ++s)
    for (int round = 0; round < 60; ++round) {
      std::string bytes = sources[s];
      for (int k = 0; k < 1 + round / 6; ++k) {
        state = state * 1664525u + 1013904223u;
        bytes[state % bytes.size()] = static_cast<char>(state >> 24);
      }
      if (round % 3 == 2) bytes.resize(state % bytes.size());
      try {
        read_surface(folder.file(names[s], bytes), "mm");
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(names[s]));
      }
    }
}

TEST(RunIsolated, ReturnsTheAnswerAndSurvivesWhateverHappens) {
  EXPECT_EQ(common::run_isolated([] { return std::string("done"); }, 10).answer, "done");
  const common::ChildResult thrown =
      common::run_isolated([]() -> std::string { throw std::runtime_error("why"); }, 10);
  EXPECT_EQ(thrown.code, 1);
  EXPECT_EQ(thrown.words, "why");
  const common::ChildResult killed = common::run_isolated(
      [] {
        std::raise(SIGKILL);
        return std::string();
      },
      10);
  EXPECT_EQ(killed.end, common::ChildResult::End::killed_by_signal);
  const common::ChildResult endless = common::run_isolated(
      [] {
        pause();
        return std::string();
      },
      0.2);
  EXPECT_EQ(endless.end, common::ChildResult::End::timed_out);
}

TEST(ReadSurface, RefusesCoordinatesThatAreNotNumbers) {
  const TemporaryFolder folder;
  std::string bytes = binary_stl(box, 1000);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 84 + 12, &nan, sizeof nan);
  EXPECT_THAT(message_of(folder.file("nan.stl", bytes), "mm"), HasSubstr("facet 1"));
}

TEST(Weld, MergesNearCornersAndReportsCollapsedFacets) {
  SurfaceMesh mesh;
  mesh.points = {Vector3(0, 0, 0),    Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(1e-7, 0, 0),
                 Vector3(1, 1e-7, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)};
  mesh.triangles = {{0, 1, 2}, {3, 4, 0}, {4, 5, 6}};
  const WeldReport report = weld(mesh, 1e-6);
  EXPECT_EQ(report.points_before, 7u);
  EXPECT_EQ(report.points_after, 4u);
  EXPECT_EQ(report.collapsed, std::vector<int>{1});
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

TEST(Weld, ToleranceGrowsWithTheDistanceFromTheOrigin) {
  EXPECT_NEAR(weld_tolerance(box.points), 1e-6 * Vector3(0.31, 0.02, 0.012).norm(), 1e-18);
  SurfaceMesh far = box;
  for (Vector3& p : far.points) p.x() += 1000;
  EXPECT_GT(weld_tolerance(far.points), 1e-4);
}

}  // namespace
}  // namespace kinetostat::fea::surface_mesh_test
