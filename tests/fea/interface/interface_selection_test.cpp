#include "kinetostat/fea/interface/interface_selection.h"

#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/surface/surface_faces.h"

#include "fea/shapes.h"

namespace kinetostat::fea::interface_selection_test {
namespace {

using testing::HasSubstr;

const SurfaceMesh box = box_surface({0, 0, 0}, {0.3, 0.2, 0.1});
const SurfaceMesh tube = tube_surface(0.008, 0.02, 0.05, 24);

double area(const SurfaceMesh& mesh, const std::vector<int>& facets) {
  double sum = 0;
  for (const int f : facets) sum += mesh.area_vector(static_cast<std::size_t>(f)).norm();
  return sum;
}

// A ball of radius 1: an octahedron whose facets are split `times` and pushed to the radius.
SurfaceMesh ball(int times) {
  SurfaceMesh mesh{
      .points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      .triangles = {
          {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int i = 0; i < times; ++i) {
    SurfaceMesh finer;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      const Vector3 &a = mesh.corner(f, 0), &b = mesh.corner(f, 1), &c = mesh.corner(f, 2);
      const int base = static_cast<int>(finer.points.size());
      for (const Vector3& p : {a, b, c, Vector3(a + b), Vector3(b + c), Vector3(c + a)})
        finer.points.push_back(p.normalized());
      for (const auto& [p, q, r] : {Triangle{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}})
        finer.triangles.push_back({base + p, base + q, base + r});
    }
    weld(finer, 1e-9);
    mesh = finer;
  }
  return mesh;
}

TEST(Selection, ASphereTakesTheBallAndNotABoxThatTouchesIt) {
  SurfaceMesh both = ball(3);
  const std::size_t round = both.triangles.size();
  append(both, box_surface(Vector3(1, 1, 1) / -std::sqrt(3), Vector3(1, 1, 1) / std::sqrt(3)));
  EXPECT_EQ(select_facets(both, SphereSelector{{0, 0, 0}, 1}).size(), round);
  EXPECT_TRUE(select_facets(both, SphereSelector{{0, 0, 0}, 0.9}).empty());
  EXPECT_THAT(nearest_candidates(both, SphereSelector{{0, 0, 0}, 0.9}, "m"), HasSubstr("1 m away"));
}

TEST(Selection, AGroupIsTakenByNameAndMissedOnesAreListed) {
  SurfaceMesh named = box;
  named.groups = {{"base", {0, 1}}, {"lid", {2, 3, 4}}};
  EXPECT_EQ(select_facets(named, GroupSelector{"lid"}), (std::vector<int>{2, 3, 4}));
  EXPECT_TRUE(select_facets(named, GroupSelector{"bass"}).empty());
  EXPECT_THAT(nearest_candidates(named, GroupSelector{"bass"}, "mm"), HasSubstr("base"));
  EXPECT_THAT(nearest_candidates(box, GroupSelector{"base"}, "mm"), HasSubstr("no groups"));
}

TEST(Selection, APatchTakesTheFacetsOnItHoweverItIsDivided) {
  // The face x = 0 of the box as one fan about its middle, and half of the opposite face.
  SurfaceMesh patch;
  patch.points = {{0, 0, 0}, {0, 0.2, 0}, {0, 0.2, 0.1}, {0, 0, 0.1}, {0, 0.1, 0.05}};
  patch.triangles = {{0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}};
  EXPECT_EQ(select_facets(box, PatchSelector{patch}), (std::vector<int>{8, 9}));
  SurfaceMesh half = box;
  half.triangles = {box.triangles[10]};
  EXPECT_EQ(select_facets(box, PatchSelector{half}), (std::vector<int>{10}));
  for (Vector3& p : patch.points) p.x() -= 0.01;
  EXPECT_TRUE(select_facets(box, PatchSelector{patch}).empty());
  EXPECT_THAT(nearest_candidates(box, PatchSelector{patch}, "mm"), HasSubstr("same unit"));
}

TEST(Selection, APlaneTakesItsFaceAndNotTheSides) {
  const auto facets = select_facets(box, PlaneSelector{{0, 0.1, 0}, {-1, 0, 0}});
  EXPECT_EQ(facets, (std::vector<int>{8, 9}));
}

TEST(Selection, APlaneLooksOutOfTheMaterial) {
  const PlaneSelector inwards{{0, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(select_facets(box, inwards).empty());
  EXPECT_THAT(nearest_candidates(box, inwards, "mm"), HasSubstr("normal [-1, 0, 0]"));
}

TEST(Selection, AMissedPlaneNamesTheNearestFace) {
  const PlaneSelector plane{{0.29, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(select_facets(box, plane).empty());
  EXPECT_THAT(nearest_candidates(box, plane, "mm"),
              HasSubstr("flat faces: point [300, 100, 50] mm, normal [1, 0, 0]"));
}

TEST(Selection, ACylinderTakesTheBoreAndNotTheEnds) {
  const auto facets = select_facets(tube, CylinderSelector{{0, 0, 1}, {0, 0, 1}, 0.008, {}});
  EXPECT_EQ(facets.size(), 48u);
  EXPECT_NEAR(area(tube, facets), 24 * 2 * 0.008 * std::sin(M_PI / 24) * 0.05, 1e-12);
}

TEST(Selection, ACylinderWithALengthTakesOnlyThatPart) {
  SurfaceMesh two = tube;
  append(two, tube_surface(0.008, 0.02, 0.05, 24));
  for (std::size_t i = tube.points.size(); i < two.points.size(); ++i) two.points[i].z() += 0.1;
  const CylinderSelector whole{{0, 0, 0}, {0, 0, 1}, 0.008, {}};
  const CylinderSelector first{{0, 0, 0}, {0, 0, 1}, 0.008, 0.06};
  EXPECT_EQ(select_facets(two, whole).size(), 96u);
  EXPECT_EQ(select_facets(two, first).size(), 48u);
}

TEST(Selection, AWrongRadiusNamesTheCylindersThatAreThere) {
  const CylinderSelector wrong{{0, 0, 0}, {0, 0, 1}, 0.010, {}};
  EXPECT_TRUE(select_facets(tube, wrong).empty());
  const std::string text = nearest_candidates(tube, wrong, "mm");
  EXPECT_THAT(text, HasSubstr("radius 8 mm about axis [0, 0, 1] through [0, 0, 25], length 50"));
  EXPECT_THAT(text, HasSubstr("radius 20 mm"));
}

// Mesh generators leave slanting triangles on a bore; no hole may remain in the selection.
TEST(Selection, ACylinderOfIrregularTrianglesIsTakenWhole) {
  const std::filesystem::path meshes = KINETOSTAT_SOURCE_DIR "/meshes";
  const SurfaceMesh rod = read_surface(meshes / "bar.stl", "mm").mesh;
  const double radius = 0.005, length = 0.018;
  const auto bore = select_facets(rod, CylinderSelector{{0, 0, 0}, {0, 1, 0}, radius, {}});
  const double exact = 2 * M_PI * radius * length;
  EXPECT_LT(area(rod, bore), exact);
  EXPECT_GT(area(rod, bore), 0.99 * exact);
  Vector3 sum = Vector3::Zero();  // of a surface of revolution: none
  for (const int f : bore) sum += rod.area_vector(static_cast<std::size_t>(f));
  EXPECT_LT(sum.norm(), 1e-6 * exact);
}

TEST(Selection, AWrongRadiusOnIrregularTrianglesNamesTheBore) {
  const std::filesystem::path meshes = KINETOSTAT_SOURCE_DIR "/meshes";
  const SurfaceMesh foot = read_surface(meshes / "foot.stl", "mm").mesh;
  const CylinderSelector wrong{{0.11, 0.11, 0}, {0, 0, 1}, 0.009, {}};
  const std::vector<RoundFace> round = round_faces(foot, flat_faces(foot, 1e-6));
  const auto bore = std::find_if(round.begin(), round.end(), [](const RoundFace& face) {
    return std::abs(face.radius - 0.008) < 2e-5 && std::abs(face.length - 0.024) < 1e-4;
  });
  ASSERT_NE(bore, round.end());
  EXPECT_LT((bore->axis_point - Vector3(0.11, 0.11, 0)).norm(), 2e-5);
  EXPECT_GT(std::abs(bore->axis.z()), 0.9999);
  EXPECT_THAT(nearest_candidates(foot, wrong, "mm"), HasSubstr("cylinders: radius "));
}

TEST(Selection, AFlatCutOfACylinderIsNoCylinder) {
  // A square bar has its corners on a circle.
  const SurfaceMesh square = tube_surface(0.5, 1, 2, 4);
  EXPECT_TRUE(select_facets(square, CylinderSelector{{0, 0, 0}, {0, 0, 1}, 1, {}}).empty());
}

TEST(Selection, ABoxTakesFacetsThatAreWhollyInside) {
  EXPECT_EQ(select_facets(box, BoxSelector{Box(Vector3(-1, -1, -1), Vector3(0.1, 1, 1))}),
            (std::vector<int>{8, 9}));
  const BoxSelector beside{Box(Vector3(1, 1, 1), Vector3(2, 2, 2))};
  EXPECT_TRUE(select_facets(box, beside).empty());
  EXPECT_THAT(nearest_candidates(box, beside, "m"), HasSubstr("from [0, 0, 0] to [0.3, 0.2, 0.1]"));
}

TEST(Selection, TheNearestFaceIsTheOneTheRayMeetsFirst) {
  EXPECT_EQ(select_facets(box, NearestFaceSelector{{0.15, 0.1, 5}, {0, 0, -1}}),
            (std::vector<int>{2, 3}));
  const NearestFaceSelector past{{5, 5, 5}, {1, 0, 0}};
  EXPECT_TRUE(select_facets(box, past).empty());
  EXPECT_THAT(nearest_candidates(box, past, "m"), HasSubstr("normal"));
}

TEST(Interface, OfARectangleHasItsAreaCentroidAndAxes) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.3, 0.2, 0.1}, 3, 4, 2));
  const Interface face = interface_on(mesh, 2);
  EXPECT_NEAR(face.area, 0.02, 1e-15);
  EXPECT_NEAR((face.centroid - Vector3(0.3, 0.1, 0.05)).norm(), 0, 1e-15);
  EXPECT_EQ(face.faces, 16u);
  EXPECT_EQ(face.nodes.size(), 45u);  // 9 x 5: corners and middles
  EXPECT_NEAR(face.gyration[0], 0.2 / std::sqrt(12.0), 1e-15);
  EXPECT_NEAR(face.gyration[1], 0.1 / std::sqrt(12.0), 1e-15);
  EXPECT_NEAR(std::abs(face.principal_axes(1, 0)), 1, 1e-12);
  EXPECT_NEAR(std::abs(face.principal_axes(0, 2)), 1, 1e-12);
}

TEST(SurfaceFaces, ABoxHasSixAndATubeTwoCylinders) {
  EXPECT_EQ(flat_faces(box, 1e-6).size(), 6u);
  const auto flat = flat_faces(tube, 1e-6);
  EXPECT_EQ(flat.size(), 50u);
  EXPECT_EQ(round_faces(tube, flat).size(), 2u);
}

}  // namespace
}  // namespace kinetostat::fea::interface_selection_test
