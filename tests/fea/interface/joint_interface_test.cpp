// Faces that a joint may hold, on solids whose faces are known.
#include "kinetostat/fea/interface/joint_interface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/fea/mesh/surface_import.h"

#include "fea/shapes.h"

namespace kinetostat::fea::joint_interface_test {
namespace {

using testing::HasSubstr;

const SurfaceMesh box = box_surface({0, -0.02, -0.03}, {0.3, 0.02, 0.03});

double mean_x(const SurfaceMesh& mesh, const JointInterface& face) {
  double sum = 0;
  for (const int f : face.facets) sum += mesh.centroid(static_cast<std::size_t>(f)).x();
  return sum / static_cast<double>(face.facets.size());
}

TEST(JointInterface, IsTheEndFaceOfABarAboutItsAxis) {
  const std::vector<JointInterface> found = joint_interfaces(box, {{0.02, 0, 0}, Vector3::UnitX()});
  ASSERT_EQ(found.size(), 1u);  // the far end is too far
  EXPECT_NEAR(found[0].area, 0.04 * 0.06, 1e-12);
  EXPECT_NEAR(mean_x(box, found[0]), 0, 1e-12);
  EXPECT_NEAR(found[0].off, -0.02, 1e-12);
  EXPECT_THAT(found[0].words, HasSubstr("flat face of 24 cm^2"));
}

TEST(JointInterface, IsNoFaceBesideTheAxis) {
  EXPECT_TRUE(joint_interfaces(box, {{0, 0.2, 0}, Vector3::UnitX()}).empty());
  EXPECT_TRUE(joint_interfaces(box, {{0, 0, 0}, Vector3(1, 1, 0).normalized()}).empty());
}

// A lug with a short bore: the bore. A long tube: its ends, each the nearer one.
TEST(JointInterface, IsTheBoreOfALugAndTheEndsOfATube) {
  const SurfaceMesh lug = tube_surface(0.02, 0.05, 0.02, 32);
  const std::vector<JointInterface> of_lug =
      joint_interfaces(lug, {{0, 0, 0.01}, Vector3::UnitZ()});
  ASSERT_FALSE(of_lug.empty());
  EXPECT_THAT(of_lug[0].words, HasSubstr("bore of radius 20 mm"));
  const SurfaceMesh tube = tube_surface(0.02, 0.03, 0.3, 32);
  const auto below = joint_interfaces(tube, {{0, 0, 0.01}, Vector3::UnitZ()});
  const auto above = joint_interfaces(tube, {{0, 0, 0.3}, Vector3::UnitZ()});
  const auto both = apart(tube, below, above);
  ASSERT_TRUE(both);
  EXPECT_THAT(both->first.words, HasSubstr("flat face"));
  EXPECT_NEAR(both->first.off, -0.01, 1e-9);
  EXPECT_NEAR(both->second.off, 0, 1e-9);
}

// Where a joint's frame is along its axis means nothing: beside the mesh it is as at its end.
TEST(JointInterface, IsFoundFromAFrameBesideTheMesh) {
  const auto found = joint_interfaces(box, {{-2, 0, 0}, Vector3::UnitX()});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(mean_x(box, found[0]), 0, 1e-12);
  EXPECT_NEAR(found[0].off, 2, 1e-12);
}

TEST(JointInterface, SurroundingsAreWhatLiesInACubeAboutTheJoint) {
  const SurfaceMesh link =
      read_surface(std::string(KINETOSTAT_SOURCE_DIR) + "/meshes/ternary_link.stl", "mm").mesh;
  const Vector3 place(0.12, 0, 0);
  const auto found = surroundings(link, {place, Vector3(1, 1, 1).normalized()});
  ASSERT_FALSE(found.empty());
  double area = std::numeric_limits<double>::max();
  for (const JointInterface& face : found) {
    EXPECT_EQ(face.facets, select_facets(link, face.selector));
    EXPECT_GE(face.rank, 1);  // after any face
    EXPECT_LE(face.area, area);
    area = face.area;
    EXPECT_NEAR(face.off, 0, 1e-12);
    const double reach = std::get<BoxSelector>(face.selector).box.sizes().x() / 2;
    for (const int f : face.facets)
      for (const int corner : link.triangles[static_cast<std::size_t>(f)])
        EXPECT_LE((link.points[static_cast<std::size_t>(corner)] - place).cwiseAbs().maxCoeff(),
                  reach * 1.01);  // and what the selector allows
  }
  EXPECT_TRUE(surroundings(link, {Vector3(0, 0, 1), Vector3::UnitX()}).empty());
}

// What it picks are just the facets of the bores that the link file of this mesh names by hand.
TEST(JointInterface, PicksTheBoresOfAShippedLink) {
  const SurfaceMesh mesh =
      read_surface(std::string(KINETOSTAT_SOURCE_DIR) + "/meshes/ternary_link.stl", "mm").mesh;
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(0.12, 0, 0), Vector3(0.045, 0.08, 0)}) {
    const auto found = joint_interfaces(mesh, {place, -Vector3::UnitZ()});
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].facets,
              select_facets(mesh, CylinderSelector{place, Vector3::UnitZ(), 0.010, {}}));
  }
}

TEST(JointInterface, TwoAreNeverTheSameNorTouch) {
  const auto ends = joint_interfaces(box, {{0, 0, 0}, Vector3::UnitX()});
  EXPECT_FALSE(apart(box, ends, ends));
  EXPECT_FALSE(apart(box, ends, joint_interfaces(box, {{0.15, 0, 0.03}, Vector3::UnitZ()})));
}

}  // namespace
}  // namespace kinetostat::fea::joint_interface_test
