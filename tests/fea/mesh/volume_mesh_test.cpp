#include "kinetostat/fea/mesh/volume_mesh.h"

#include <cstdlib>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/fea/elasticity/elasticity.h"
#include "kinetostat/fea/mesh/gmsh_program.h"
#include "kinetostat/fea/mesh/surface_import.h"

#include "fea/shapes.h"
#include "support/program.h"

namespace kinetostat::fea::volume_mesh_test {
namespace {

using testing::HasSubstr;

// Two tetrahedra on a common side, a named face at the bottom; the second is over the first.
const char* const two_22 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n2\n2 7 \"foot print\"\n3 1 \"steel\"\n$EndPhysicalNames\n"
    "$Nodes\n6\n1 0 0 0\n2 10 0 0\n3 0 10 0\n4 0 0 10\n5 10 10 10\n99 5 5 5\n$EndNodes\n"
    "$Elements\n4\n1 15 2 0 1 1\n2 2 2 7 1 1 2 3\n3 4 2 1 1 1 2 3 4\n4 4 2 1 1 2 4 5 3\n"
    "$EndElements\n";
const char* const two_41 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n2\n2 7 \"foot print\"\n3 1 \"steel\"\n$EndPhysicalNames\n"
    "$Entities\n0 0 1 1\n3 0 0 0 10 10 0 1 7 0\n5 0 0 0 10 10 10 1 1 1 3\n$EndEntities\n"
    "$Nodes\n1 5 1 5\n3 5 0 5\n1\n2\n3\n4\n5\n0 0 0\n10 0 0\n0 10 0\n0 0 10\n10 10 10\n$EndNodes\n"
    "$Elements\n2 3 1 3\n2 3 2 1\n1 1 2 3\n3 5 4 2\n2 1 2 3 4\n3 2 4 5 3\n$EndElements\n";
const char* const two_inp =
    "** made by hand\n*Heading\nanything, at all\n*NODE, NSET=all\n1, 0., 0., 0.\n2, 10., 0, 0\n"
    "3, 0, 1.e1, 0\n4, 0, 0, 10\n5, 10, 10, 10\n"
    "*ELEMENT, TYPE=C3D4, ELSET=Steel\n11, 1, 2, 3, 4\n12, 2, 4,\n5, 3\n"
    "*ELSET, ELSET=lower, GENERATE\n11, 11\n*NSET, NSET=bottom\n1, 2,\n3,\n"
    "*SURFACE, NAME=\"foot print\"\nLOWER, S1\n*STEP\n*STATIC\n";

std::vector<std::string> names(const std::vector<FacetGroup>& groups) {
  std::vector<std::string> list;
  for (const FacetGroup& group : groups) list.push_back(group.name);
  return list;
}

std::string message_of(const std::filesystem::path& file) {
  try {
    read_volume_mesh(file, "mm");
  } catch (const common::InputError& error) {
    return error.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

void expect_the_two(const ImportedVolume& volume) {
  ASSERT_EQ(volume.mesh.element_count(), 2u);
  EXPECT_EQ(volume.mesh.nodes.size(), 5u);  // the sixth belongs to no element
  EXPECT_EQ(volume.mesh.boundary.size(), 6u);
  EXPECT_NEAR(mass_properties(volume.mesh).volume, 1e-6 / 6 + 1e-6 / 3, 1e-18);
  ASSERT_THAT(names(volume.surface.groups), testing::Contains("foot print"));
  for (const FacetGroup& group : volume.surface.groups) {
    ASSERT_EQ(group.facets.size(), 1u) << group.name;
    const Vector3 area = volume.surface.area_vector(static_cast<std::size_t>(group.facets[0]));
    EXPECT_NEAR((area - Vector3(0, 0, -50e-6)).norm(), 0, 1e-15) << "outward is down";
  }
}

TEST(VolumeMesh, TheSameTwoTetrahedraInThreeFormats) {
  const TemporaryFolder folder;
  for (const auto& file : {folder.file("22.msh", two_22), folder.file("41.msh", two_41)}) {
    const ImportedVolume volume = read_volume_mesh(file, "mm");
    expect_the_two(volume);
    ASSERT_EQ(volume.element_groups.size(), 1u);
    EXPECT_EQ(volume.element_groups[0].name, "steel");
    EXPECT_TRUE(holds_volume_mesh(file));
  }
  const std::string without_all = replaced(two_inp, ", NSET=all", "");
  const ImportedVolume inp = read_volume_mesh(folder.file("two.inp", without_all), "mm");
  expect_the_two(inp);
  EXPECT_THAT(names(inp.surface.groups), testing::ElementsAre("bottom", "foot print"));
  ASSERT_EQ(inp.element_groups.size(), 2u);
  EXPECT_EQ(inp.element_groups[0].name, "Steel");
  EXPECT_EQ(inp.element_groups[1].elements, std::vector<int>{0});
}

TEST(VolumeMesh, OneGroupOfElementsIsASolidOfItsOwn) {
  const TemporaryFolder folder;
  const auto file = folder.file("two.inp", replaced(two_inp, ", NSET=all", ""));
  const std::string name = read_volume_mesh(file, "mm").element_groups[1].name;
  const ImportedVolume one = read_volume_mesh(file, "mm", name);
  EXPECT_EQ(one.mesh.element_count(), 1u);
  EXPECT_EQ(one.mesh.nodes.size(), 4u);
  EXPECT_EQ(one.mesh.boundary.size(), 4u);  // with the face that the other one was at
  EXPECT_EQ(one.element_groups.back().elements, std::vector<int>{0});
  try {
    read_volume_mesh(file, "mm", "Stel");
    FAIL();
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the mesh has no group of elements 'Stel'. Did you mean "
                                        "'Steel'? The groups are"));
  }
}

TEST(VolumeMesh, DamageIsNamedWithItsLine) {
  const TemporaryFolder folder;
  const auto msh = [&](const std::string& what, const std::string& by, const char* text = two_22) {
    return message_of(folder.file("a.msh", replaced(text, what, by)));
  };
  EXPECT_THAT(msh("2.2 0 8", "4.0 0 8"), HasSubstr("2.2 and 4.1 are read"));
  EXPECT_THAT(msh("2 10 0 0", "2 ten 0 0"), HasSubstr("a.msh:12: 'ten' is not a number"));
  EXPECT_THAT(msh("2 10 0 0", "1 10 0 0"), HasSubstr("node 1 is there twice"));
  EXPECT_THAT(msh("2 10 0 0", "2 nan 0 0"), HasSubstr("node 2 is not finite"));
  EXPECT_THAT(msh("3 4 2 1 1 1 2 3 4", "3 4 2 1 1 1 2 3 8"),
              HasSubstr("a.msh:22: element 3 names node 8"));
  EXPECT_THAT(msh("3 4 2 1 1 1 2 3 4", "3 4 2 1 1 1 3 2 4"),
              HasSubstr("a.msh:22: element 3 is inside out"));
  EXPECT_THAT(msh("3 4 2 1 1 1 2 3 4", "3 5 2 1 1 1 2 3 4"),
              HasSubstr("tetrahedra of 4 and 10 nodes"));
  EXPECT_THAT(msh("3 4 2 1 1 1 2 3 4", "3 4 2 1 1 1 2 3 3"), HasSubstr("element 3 is flat"));
  EXPECT_THAT(msh("$Nodes\n6", "$Nodes\n600000000"), HasSubstr("cut short"));
  EXPECT_THAT(msh("$EndElements", ""), HasSubstr("$EndElements"));
  EXPECT_THAT(msh("5 4 2", "5 4 2", two_41), "");
  const auto inp = [&](const std::string& what, const std::string& by) {
    return message_of(folder.file("a.inp", replaced(two_inp, what, by)));
  };
  EXPECT_THAT(inp("2, 10., 0, 0", "2, 10., x, 0"), HasSubstr("a.inp:6: 'x' is not a coordinate"));
  EXPECT_THAT(inp("C3D4", "C3D8"), HasSubstr("only C3D4 and C3D10"));
  EXPECT_THAT(inp("12, 2, 4,\n5, 3", "12, 2, 4,\n5"),
              HasSubstr("a.inp:12: an element of type C3D4"));
  EXPECT_THAT(inp("LOWER, S1", "LOWER, S7"), HasSubstr("S1, S2, S3 and S4"));
  EXPECT_THAT(inp("LOWER, S1", "UPPER, S1"), HasSubstr("'UPPER' is neither"));
}

TEST(VolumeMesh, AMirroredFileIsRepairedWithAWarning) {
  const TemporaryFolder folder;
  const auto file = folder.file(
      "a.msh", replaced(replaced(two_22, "1 1 2 3 4\n", "1 2 1 3 4\n"), "2 4 5 3\n", "4 2 5 3\n"));
  const ImportedVolume volume = read_volume_mesh(file, "mm");
  EXPECT_EQ(volume.warnings.size(), 1u);
  EXPECT_NEAR(mass_properties(volume.mesh).volume, 0.5e-6, 1e-18);
}

TEST(VolumeMesh, NoTruncationCrashesOrPasses) {
  const TemporaryFolder folder;
  for (const std::string text : {two_22, two_41})
    for (std::size_t length = 0; length + 20 < text.size(); length += 3)
      EXPECT_NE(message_of(folder.file("a.msh", text.substr(0, length))), "") << length;
}

// An independent program writes the same ball in every format that is read.
class GmshBall : public testing::TestWithParam<const char*> {};

TEST_P(GmshBall, HasItsVolumeAndItsNamedFaces) {
  ASSERT_TRUE(test::is_installed("gmsh"));
  const TemporaryFolder folder;
  const auto script = folder.file(
      "ball.geo",
      "SetFactory(\"OpenCASCADE\");\nSphere(1) = {0, 0, 0, 10, 0, Pi/2};\n"
      "Physical Volume(\"half ball\") = {1};\nflat() = Surface In BoundingBox {-11, -11, -1, 11, "
      "11, 1};\n"
      "Physical Surface(\"flat\") = {flat()};\nround() = Surface{:}; round() -= {flat()};\n"
      "Physical Surface(\"round\") = {round()};\nMesh.MeshSizeMax = 4;\nMesh.ElementOrder = 2;\n"
      "Mesh.HighOrderOptimize = 0;\n");
  const std::string name =
      std::string("ball.") + (std::string(GetParam()).find("inp") == 0 ? "inp" : "msh");
  const auto file = folder.path() / name;
  const std::string command = fmt::format("gmsh {} -3 -format {} -o {} -v 0 -nt 1", script.string(),
                                          GetParam(), file.string());
  ASSERT_EQ(std::system(command.c_str()), 0);
  const ImportedVolume ball = read_volume_mesh(file, "mm");
  EXPECT_EQ(ball.mesh.order, 2);
  EXPECT_TRUE(ball.mesh.curved);
  const double exact = 2.0 / 3 * M_PI * 1e-6;
  EXPECT_NEAR(mass_properties(ball.mesh).volume, exact, 2e-3 * exact);
  TetMesh straight = ball.mesh;
  straight.curved = false;  // the corners alone miss much more
  EXPECT_LT(mass_properties(straight).volume, 0.98 * exact);
  std::map<std::string, double> areas;
  for (const FacetGroup& group : ball.surface.groups)
    for (const int f : group.facets)
      areas[group.name] += ball.surface.area_vector(static_cast<std::size_t>(f)).norm();
  EXPECT_NEAR(areas.at("flat"), M_PI * 1e-4, 0.05 * M_PI * 1e-4);
  EXPECT_NEAR(areas.at("round"), 2 * M_PI * 1e-4, 0.05 * 2 * M_PI * 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Formats, GmshBall,
                         testing::Values("msh22", "msh41", "msh22 -bin", "msh41 -bin",
                                         "inp -save_all"));

// x' = x + y^2 / 4 keeps volumes, and ten-node elements follow it exactly.
TetMesh sheared(TetMesh mesh) {
  for (Vector3& p : mesh.nodes) p.x() += 0.25 * p.y() * p.y();
  mesh.curved = true;
  return mesh;
}

TEST(CurvedElements, AQuadraticMapHasTheMassPropertiesOfTheExactSolid) {
  const TetMesh mesh = sheared(with_mid_nodes(box_mesh({3, 2, 1}, 3, 2, 2)));
  const MassProperties properties = mass_properties(mesh);
  EXPECT_NEAR(properties.volume, 6, 1e-12);
  // The mean of y^2 / 4 over 0..2 is 1/3.
  EXPECT_NEAR((properties.centroid - Vector3(1.5 + 1.0 / 3, 1, 0.5)).norm(), 0, 1e-12);
  EXPECT_NEAR(properties.second_moment(2, 2), 6.0 / 12, 1e-12);
}

TEST(CurvedElements, StraightOnesHaveTheStiffnessOfStraightOnes) {
  const Material steel(210e9, 0.3);
  const TetMesh mesh = with_mid_nodes(box_mesh({3, 2, 1}, 1, 1, 1));
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto straight = stiffness_tet10(mesh.corners(e), steel);
    const auto curved = stiffness_curved_tet10(mesh.all_nodes(e), steel);
    EXPECT_LT((curved - straight).norm(), 1e-13 * straight.norm());
    EXPECT_NEAR(least_jacobian(mesh, e), 1, 1e-12);
  }
}

TEST(CurvedElements, RigidMotionsCostNothingAndStretchCostsItsEnergy) {
  const Material steel(210e9, 0.3);
  const TetMesh mesh = sheared(with_mid_nodes(box_mesh({3, 2, 1}, 2, 2, 2)));
  double stretch_energy = 0;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto nodes = mesh.all_nodes(e);
    const auto k = stiffness_curved_tet10(nodes, steel);
    Eigen::Matrix<double, 30, 1> turn, stretch;
    for (Eigen::Index i = 0; i < 10; ++i) {
      const Vector3& p = nodes[static_cast<std::size_t>(i)];
      turn.segment<3>(3 * i) = Vector3(1, 2, 3).cross(p) + Vector3(4, 5, 6);
      stretch.segment<3>(3 * i) = Vector3(p.x(), 0, 0);
    }
    EXPECT_LT((k * turn).norm(), 1e-12 * k.norm() * turn.norm());
    stretch_energy += stretch.dot(k * stretch);
  }
  // A unit strain in x alone costs lambda + 2 mu a volume; the four points integrate a constant
  // times the determinant, which is linear here.
  EXPECT_NEAR(stretch_energy, 6 * (steel.lambda() + 2 * steel.mu()), 1e-10 * stretch_energy);
}

TEST(CurvedElements, OneThatFoldsOverIsRefusedByName) {
  const TemporaryFolder folder;
  const std::string text =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n"
      "9,.5,0,.5\n10,0,.5,.5\n*ELEMENT, TYPE=C3D10\n1,1,2,3,4,5,6,7,8,9,10\n";
  EXPECT_EQ(message_of(folder.file("good.inp", text)), "");
  EXPECT_THAT(message_of(folder.file("bad.inp", replaced(text, "5,.5,0,0", "5,.9,0,0"))),
              HasSubstr("bad.inp:13: element 1 is turned inside out by its mid nodes"));
}

// gmsh obeys two files in the home folder; each may start programs.
TEST(GmshTetrahedra, RunNoCommands) {
  ASSERT_TRUE(test::is_installed("gmsh"));
  const TemporaryFolder folder;
  const auto mark = folder.path() / "ran";
  const std::string command = fmt::format("SystemCall \"touch {}\";\n", mark.string());
  for (const char* name : {".gmshrc", ".gmsh-options"}) folder.file(name, command);
  const std::string home = std::getenv("HOME") == nullptr ? "" : std::getenv("HOME");
  setenv("HOME", folder.path().c_str(), 1);
  common::Progress silent;
  const TetMesh mesh =
      gmsh_tetrahedra(box_surface({0, 0, 0}, {1, 1, 1}), std::vector<int>(12, 0), 0.5, {}, silent);
  setenv("HOME", home.c_str(), 1);
  EXPECT_FALSE(std::filesystem::exists(mark));
  EXPECT_NEAR(mass_properties(mesh).volume, 1, 1e-9);
}

TEST(Step, ScriptsOfGmshAreNotRead) {
  const TemporaryFolder folder;
  const auto mark = folder.path() / "ran";
  const std::string script = fmt::format("SystemCall \"touch {}\";\n", mark.string());
  for (const char* name : {"link.geo", "link.step", "link.stp", "link.msh"})
    EXPECT_THROW(read_surface(folder.file(name, script), "mm"), common::InputError) << name;
  EXPECT_FALSE(std::filesystem::exists(mark));
}

TEST(GmshTetrahedra, FillABoxWithACavityAndKeepTheTags) {
  ASSERT_TRUE(test::is_installed("gmsh"));
  SurfaceMesh surface = box_surface({0, 0, 0}, {3, 2, 1});
  append(surface, inverted(box_surface({1, 0.5, 0.25}, {2, 1.5, 0.75})));
  std::vector<int> tags(24, 0);
  tags[0] = tags[1] = 4;  // the lower side, see shapes.h
  common::Progress silent;
  const TetMesh mesh = gmsh_tetrahedra(surface, tags, 0.5, {}, silent);
  EXPECT_NEAR(mass_properties(mesh).volume, 5.5, 1e-9);
  double tagged = 0;
  for (const BoundaryFace& face : mesh.boundary) {
    if (face.tag != 4) continue;
    const auto p = [&](std::size_t k) {
      return mesh.nodes[static_cast<std::size_t>(face.nodes[k])];
    };
    tagged += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    EXPECT_NEAR(p(0).z(), 0, 1e-12);
  }
  EXPECT_NEAR(tagged, 6, 1e-9);
}

}  // namespace
}  // namespace kinetostat::fea::volume_mesh_test
