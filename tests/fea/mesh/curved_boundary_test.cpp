#include "kinetostat/fea/mesh/curved_boundary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "kinetostat/fea/mesh/surface_import.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"

#include "fea/surface/step_parts.h"
#include "support/temporary_folder.h"

namespace kinetostat::fea::curved_boundary_test {
namespace {

constexpr double pi = std::numbers::pi;

// A part of a STEP file, filled with tetrahedra whose boundary is tagged with its faces.
struct Part {
  explicit Part(const std::filesystem::path& file)
      : surface(read_surface(file, "mm", {.sides = 16})),
        mesh(tetrahedralize(surface.mesh, face_of_facets(surface.mesh), {}, silent)) {}

  CadBoundary cad() const {
    CadBoundary cad{.step = surface.step, .faces = surface.mesh.faces};
    for (const BoundaryFace& face : mesh.boundary) cad.face_of.push_back(face.tag);
    return cad;
  }

  common::Progress silent = {};
  ImportedSurface surface;
  TetMesh mesh;
};

TEST(CurvedBoundary, NodesLieOnTheRoundBarAndItsVolumeIsExactToFourDigits) {
  const test::TemporaryFolder folder;
  test::write_round_bar(folder.path() / "bar.step", 40, 200);
  Part part(folder.path() / "bar.step");
  const double exact = pi * 0.02 * 0.02 * 0.2;
  EXPECT_LT(mass_properties(part.mesh).volume, 0.995 * exact);
  for (const int order : {1, 2}) {
    const TetMesh mesh = on_cad_faces(part.mesh, part.cad(), order, part.silent);
    EXPECT_EQ(mesh.order, order);
    EXPECT_EQ(mesh.curved, order == 2);
    EXPECT_EQ(mesh.straightened, 0u);
    for (std::size_t f = 0; f < mesh.boundary.size(); ++f)
      for (std::size_t k = 0; k < mesh.nodes_per_face(); ++k) {
        const Vector3& p = mesh.nodes[static_cast<std::size_t>(mesh.boundary[f].nodes[k])];
        if (part.surface.mesh.faces[static_cast<std::size_t>(mesh.boundary[f].tag - 1)].kind ==
            FaceKind::cylinder) {
          EXPECT_NEAR(p.tail<2>().norm(), 0.02, 1e-10);
        } else {
          EXPECT_NEAR(std::min(std::abs(p.x()), std::abs(p.x() - 0.2)), 0, 1e-12);
        }
      }
    const double off = std::abs(mass_properties(mesh).volume / exact - 1);
    EXPECT_LT(off, order == 1 ? 0.02 : 1e-4);
    // What is missing is the gap times the area, to within the sign of the gap.
    double gap = 0;
    for (std::size_t f = 0; f < mesh.boundary.size(); ++f) {
      const auto p = [&](std::size_t k) {
        return mesh.nodes[static_cast<std::size_t>(mesh.boundary[f].nodes[k])];
      };
      gap += mesh.gaps[f] * 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
    }
    EXPECT_GE(1.2 * gap, off * exact);
    if (order == 1) {
      EXPECT_LT(gap, 1.2 * off * exact);
    }
  }
}

TEST(CurvedBoundary, ElementsThatWouldTurnInsideOutStayStraight) {
  const test::TemporaryFolder folder;
  test::write_bored_block(folder.path() / "block.step", 20);
  const ImportedSurface block = read_surface(folder.path() / "block.step", "mm");
  const auto bore =
      std::find_if(block.mesh.faces.begin(), block.mesh.faces.end(),
                   [](const CadFace& face) { return face.kind == FaceKind::cylinder; });
  const int number = static_cast<int>(bore - block.mesh.faces.begin()) + 1;
  // A chord across the bore, and a corner in the material just behind the arc that it becomes.
  const double angle = 25 * pi / 180;
  TetMesh flat{.nodes = {{0.01 * std::cos(angle), 0.01 * std::sin(angle), 0},
                         {0.01 * std::cos(angle), -0.01 * std::sin(angle), 0},
                         {0.01, 0, 0.005},
                         {0.0102, 0, 0.001},
                         {0.03, 0.03, 0},  // and another element, far away
                         {0.03, -0.03, 0},
                         {0.02, -0.03, 0},
                         {0.03, 0.03, 0.01}},
               .connectivity = {0, 1, 2, 3, 4, 5, 6, 7},
               .boundary = {{.nodes = {0, 1, 2, -1, -1, -1}, .tag = number}}};
  for (const std::size_t e : {0u, 1u})
    if (volume(flat.corners(e)) < 0)
      std::swap(flat.connectivity[4 * e], flat.connectivity[4 * e + 1]);
  common::Progress silent;
  const CadBoundary cad{.step = block.step, .faces = block.mesh.faces, .face_of = {number}};
  const TetMesh mesh = on_cad_faces(flat, cad, 2, silent);
  EXPECT_EQ(mesh.straightened, 1u);
  EXPECT_GE(least_jacobian(mesh, 0), 0.2);
  EXPECT_GT(mesh.gaps[0], 1e-4);
  // Farther behind, it has room.
  flat.nodes[3].x() = 0.03;
  const TetMesh roomy = on_cad_faces(flat, cad, 2, silent);
  EXPECT_EQ(roomy.straightened, 0u);
  EXPECT_LT(roomy.gaps[0], mesh.gaps[0] / 5);
}

}  // namespace
}  // namespace kinetostat::fea::curved_boundary_test
