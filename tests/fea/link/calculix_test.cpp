// The exported deck solved by CalculiX, an independent program.
#include <cstdlib>

#include <gtest/gtest.h>

#include "kinetostat/fea/link/calculix_deck.h"
#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/io/text_file.h"

#include "fea/shapes.h"
#include "support/program.h"

namespace kinetostat::fea::calculix_test {
namespace {

// A bent block, so that nothing is symmetric. The top near the end is a third interface.
TetMesh bent_block(int order) {
  TetMesh mesh = box_mesh({0.1, 0.03, 0.02}, 8, 3, 2);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const auto& side : {std::array{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}) {
      BoundaryFace face{.nodes = {-1, -1, -1, -1, -1, -1}, .tag = 3};
      bool on_top = true;
      for (std::size_t c = 0; c < 3; ++c) {
        face.nodes[c] = mesh.element(e)[static_cast<std::size_t>(side[c])];
        const Vector3& p = mesh.nodes[static_cast<std::size_t>(face.nodes[c])];
        on_top = on_top && p.z() == 0.02 && p.x() > 0.03 && p.x() < 0.07;
      }
      if (on_top) mesh.boundary.push_back(face);
    }
  for (Vector3& p : mesh.nodes) p += Vector3(0.1 * p.z(), 3 * p.x() * p.x(), 0.2 * p.x());
  return order == 2 ? with_mid_nodes(mesh) : mesh;
}

Eigen::MatrixXd solved_by_calculix(const std::string& deck, int loaded) {
  const TemporaryFolder folder;
  folder.file("link.inp", deck);
  const std::string call = "cd '" + folder.path().string() + "' && ccx link > ccx.log 2>&1";
  EXPECT_EQ(std::system(call.c_str()), 0) << io::read_text(folder.path() / "ccx.log");
  return read_calculix_flexibility(io::read_text(folder.path() / "link.dat"), loaded);
}

void expect_agreement(const TetMesh& mesh, const std::vector<Coupling>& couplings) {
  std::vector<CoupledInterface> interfaces;
  for (const Coupling coupling : couplings) {
    const Interface geometry = interface_on(mesh, static_cast<int>(interfaces.size()) + 1);
    interfaces.push_back({.name = "i" + std::to_string(interfaces.size()),
                          .geometry = geometry,
                          .point = geometry.centroid + Vector3(0.01, 0.02, -0.03),
                          .coupling = coupling});
  }
  const std::vector<Material> materials{Material(210e9, 0.3)};
  common::Progress silent;
  const Eigen::MatrixXd ours = respond(mesh, materials, interfaces, {}, silent).flexibility;
  const Solid solid = with_stiff_bodies(mesh, materials, interfaces);
  const Eigen::MatrixXd other =
      solved_by_calculix(calculix_deck("bent block", solid.mesh, solid.materials, interfaces),
                         static_cast<int>(couplings.size()) - 1);
  for (Eigen::Index i = 0; i < ours.rows(); ++i)
    for (Eigen::Index j = 0; j < ours.cols(); ++j)
      // 0.05 %; CalculiX prints seven digits.
      EXPECT_NEAR(ours(i, j), other(i, j),
                  5e-4 * std::abs(other(i, j)) + 1e-6 * std::sqrt(ours(i, i) * ours(j, j)))
          << i << j;
}

class CalculiX : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(test::is_installed("ccx")); }
};

TEST_F(CalculiX, AgreesOnTheSameModelWithRigidInterfaces) {
  expect_agreement(bent_block(2), {Coupling::rigid, Coupling::rigid});
  expect_agreement(bent_block(1), {Coupling::rigid, Coupling::rigid});
}

TEST_F(CalculiX, AgreesWithDistributingInterfacesAtEitherEnd) {
  expect_agreement(bent_block(2), {Coupling::rigid, Coupling::distributing});
  expect_agreement(bent_block(2), {Coupling::distributing, Coupling::rigid});
  expect_agreement(bent_block(2), {Coupling::distributing, Coupling::distributing});
}

TEST_F(CalculiX, AgreesWithBodiesOnTheInterfaces) {
  expect_agreement(bent_block(2), {Coupling::body, Coupling::rigid});
  expect_agreement(bent_block(2), {Coupling::rigid, Coupling::body});
}

TEST_F(CalculiX, AgreesOnThreeInterfaces) {
  expect_agreement(bent_block(2), {Coupling::rigid, Coupling::rigid, Coupling::distributing});
}

TEST(CalculixDat, MustHoldEveryStep) {
  EXPECT_THROW(read_calculix_flexibility("  7  1.0 2.0 3.0\n", 1), std::runtime_error);
}

}  // namespace
}  // namespace kinetostat::fea::calculix_test
