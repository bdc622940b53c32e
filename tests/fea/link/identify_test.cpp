#include "kinetostat/fea/link/identify.h"

#include <atomic>
#include <cstdlib>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/fea/link/displacement_fields.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/pose.h"
#include "kinetostat/spatial/rotation.h"

#include "fea/shapes.h"

namespace kinetostat::fea::identify_test {
namespace {

using testing::HasSubstr;

const SurfaceMesh bar = box_surface({0, -0.01, -0.006}, {0.1, 0.01, 0.006});

std::string text(const Vector3& v) {
  return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) +
         "]";
}

// The link file of the bar moved by `pose`: held at one end, loaded at the other.
std::string link_text(const spatial::Pose& pose = {}, const std::string& rest = "") {
  return "kinetostat: 1\nlink: bar\nmesh: {file: bar.stl, unit: mm}\n"
         "material: {E: 210 GPa, nu: 0.3, density: 7850 kg/m^3}\n"
         "fixed: {plane: {point: " +
         text(1000 * (pose * Vector3::Zero())) +
         ", normal: " + text(pose.rotation() * Vector3(-1, 0, 0)) +
         "}}\n"
         "loaded: {plane: {point: " +
         text(1000 * (pose * Vector3(0.1, 0, 0))) +
         ", normal: " + text(pose.rotation() * Vector3(1, 0, 0)) +
         "}}\n"
         "elements: {size: 8}\n" +
         rest;
}

// Cancels for good when it has been asked `patience` times.
class Impatient : public common::Progress {
 public:
  explicit Impatient(int patience) : patience_(patience) {}
  bool cancelled() const override { return ++asked_ > patience_; }
  int asked() const { return asked_; }

 private:
  int patience_;
  mutable std::atomic<int> asked_ = 0;
};

class Identify : public testing::Test {
 protected:
  LinkResult run(const SurfaceMesh& surface, const std::string& link) {
    common::Progress silent;
    return run(surface, link, silent);
  }
  LinkResult run(const SurfaceMesh& surface, const std::string& link, common::Progress& progress) {
    folder_.file("bar.stl", binary_stl(surface, 1000));
    IdentifyOptions options;
    options.meshing.helper = KINETOSTAT_TETGEN;
    const LinkSpec spec = read_link(folder_.file("bar.yaml", link));
    return identify(spec, read_geometry(spec, progress), options, progress);
  }
  std::string message(const SurfaceMesh& surface, const std::string& link) {
    try {
      run(surface, link);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(Identify, GivesASymmetricPositiveDefiniteComplianceAtTheCentroid) {
  const LinkResult result = run(bar, link_text());
  EXPECT_LT(result.symmetry_defect, 1e-9);
  EXPECT_EQ(Eigen::LLT<Matrix6>(result.compliance.matrix()).info(), Eigen::Success);
  EXPECT_NEAR((result.compliance.frame().point - Vector3(0.1, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(*result.mass, 7850 * 0.1 * 0.02 * 0.012, 1e-6);
  EXPECT_NEAR((result.center_of_mass - Vector3(0.05, 0, 0)).norm(), 0, 1e-8);
}

// At whatever moment the user stops it: all of the result, or none of it.
TEST_F(Identify, CancelledAtAnyMomentItGivesNoPartOfAResult) {
  Impatient patient(std::numeric_limits<int>::max());
  const LinkResult whole = run(bar, link_text(), patient);
  ASSERT_TRUE(whole.bracket);
  int cancelled = 0;
  for (int patience = 0; patience <= patient.asked(); ++patience) {
    Impatient user(patience);
    try {
      const LinkResult result = run(bar, link_text(), user);
      EXPECT_TRUE(result.bracket) << "cancelled when asked " << patience + 1 << " times";
    } catch (const common::Cancelled&) {
      ++cancelled;
    }
  }
  EXPECT_GE(cancelled, 10);
}

// The stored energy of each field is half the work of its wrench: C = U' K U.
TEST_F(Identify, EnergyOfTheFieldsIsTheWorkOfTheWrenches) {
  const LinkResult result = run(bar, link_text());
  common::Progress silent;
  common::ThreadPool pool(2);
  const DofMap all(result.mesh, {}, {});
  const BlockMatrix k = assemble(result.mesh, {result.material}, all, pool, silent);
  Eigen::MatrixXd u(k.size(), 6);
  for (Eigen::Index j = 0; j < 6; ++j)
    u.col(j) = values_of(all, result.response.fields[static_cast<std::size_t>(j)]);
  const Matrix6 energy = -u.transpose() * k.residual(Eigen::MatrixXd::Zero(k.size(), 6), u);
  const Matrix6& c = result.compliance.matrix();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(energy(i, j), c(i, j), 1e-9 * std::sqrt(c(i, i) * c(j, j))) << i << j;
}

TEST_F(Identify, TheFixedInterfaceStaysAndTheLoadedOneMovesRigidly) {
  const LinkResult result = run(bar, link_text());
  const Vector3 point = result.compliance.frame().point;
  for (std::size_t j = 0; j < 6; ++j) {
    const Eigen::Matrix3Xd& u = result.response.fields[j];
    for (const int n : result.interfaces[0].geometry.nodes) EXPECT_EQ(u.col(n).norm(), 0);
    const Vector6 body = result.response.compliance().col(static_cast<Eigen::Index>(j));
    for (const int n : result.interfaces[1].geometry.nodes)
      EXPECT_NEAR(
          (u.col(n) -
           spatial::rigid_motion(result.mesh.nodes[static_cast<std::size_t>(n)] - point) * body)
              .norm(),
          0, 1e-12 * u.norm());
  }
}

// Turning and moving the mesh turns and moves the compliance. TetGen's mesh is another one, so the
// agreement is that of two meshes.
TEST_F(Identify, TheComplianceTurnsWithTheMesh) {
  const spatial::Pose pose(spatial::exp_rotation(Vector3(0.4, -0.7, 1.1)), Vector3(0.3, 0.2, -0.5));
  SurfaceMesh moved = bar;
  for (Vector3& p : moved.points) p = pose * p;
  const LinkResult a = run(bar, link_text()), b = run(moved, link_text(pose));
  const spatial::Frame frame{.point = b.compliance.frame().point, .axes = pose.rotation()};
  const Matrix6 turned = b.compliance.in(frame).matrix();
  const Matrix6& straight = a.compliance.matrix();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(turned(i, j), straight(i, j), 3e-3 * std::sqrt(straight(i, i) * straight(j, j)))
          << i << j;
}

// On the same elements the invariance is exact.
TEST_F(Identify, TheComplianceOfTurnedElementsIsTheTurnedCompliance) {
  const Matrix3 turn = spatial::exp_rotation(Vector3(0.4, -0.7, 1.1));
  common::Progress silent;
  common::ThreadPool pool(2);
  const Material steel(210e9, 0.3);
  const auto compliance = [&](const Matrix3& r) {
    TetMesh mesh = with_mid_nodes(box_mesh({0.1, 0.02, 0.012}, 8, 2, 2));
    for (Vector3& p : mesh.nodes) p = r * p;
    const std::vector<CoupledInterface> ends = coupled_ends(mesh);
    return spatial::Compliance6(respond(mesh, {steel}, ends, {}, silent).compliance(),
                                {.point = ends[1].point});
  };
  const spatial::Compliance6 straight = compliance(Matrix3::Identity()), turned = compliance(turn);
  const Matrix6 back = turned.in({.point = turned.frame().point, .axes = turn}).matrix();
  const Matrix6& c = straight.matrix();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(back(i, j), c(i, j), 1e-10 * std::sqrt(c(i, i) * c(j, j))) << i << j;
}

TEST_F(Identify, AHelperWithoutMemoryIsNoBadInput) {
  folder_.file("bar.stl", binary_stl(bar, 1000));
  IdentifyOptions options;
  options.meshing.helper = folder_.file("helper", "#!/bin/sh\nexit 65\n");
  std::filesystem::permissions(options.meshing.helper, std::filesystem::perms::owner_all);
  options.meshing.remesher = "/nonexistent";
  const std::string path = std::getenv("PATH");
  setenv("PATH", "", 1);  // no gmsh
  common::Progress silent;
  const LinkSpec spec = read_link(folder_.file("bar.yaml", link_text()));
  try {
    identify(spec, read_geometry(spec, silent), options, silent);
    ADD_FAILURE() << "a mesh out of nothing";
  } catch (const common::OutOfMemory& error) {
    EXPECT_THAT(error.what(), HasSubstr("bar.stl: TetGen needs more memory than there is"));
    EXPECT_THAT(error.what(), HasSubstr("Use a larger element size"));
  }
  setenv("PATH", path.c_str(), 1);
}

TEST_F(Identify, AModelAboveTheMemoryThatItMayHaveIsNoBadInput) {
  folder_.file("bar.stl", binary_stl(bar, 1000));
  IdentifyOptions options;
  options.meshing.helper = KINETOSTAT_TETGEN;
  options.solver.memory = 1 << 20;
  common::Progress silent;
  const LinkSpec spec = read_link(folder_.file("bar.yaml", link_text()));
  try {
    identify(spec, read_geometry(spec, silent), options, silent);
    ADD_FAILURE() << "a model in a megabyte";
  } catch (const common::OutOfMemory& error) {
    EXPECT_THAT(error.what(), HasSubstr("bar.yaml: the direct solver needs"));
    EXPECT_THAT(error.what(), HasSubstr("(--memory)"));
  }
}

TEST_F(Identify, FourNodeElementsAreStifferAndSaidToBe) {
  std::string order1 = link_text();
  order1.replace(order1.find("{size: 8}"), 9, "{order: 1, size: 8}");
  const LinkResult two = run(bar, link_text()), one = run(bar, order1);
  EXPECT_LT(one.compliance.matrix()(2, 2), 0.95 * two.compliance.matrix()(2, 2));
  EXPECT_THAT(one.warnings, testing::Contains(HasSubstr("too stiff")));
}

TEST_F(Identify, AnEmptySelectionNamesTheNearestFaces) {
  std::string link = link_text();
  link.replace(link.find("point: [0.000000"), 16, "point: [7.000000");
  const std::string text = message(bar, link);
  EXPECT_THAT(text, HasSubstr("bar.yaml:5"));
  EXPECT_THAT(text, HasSubstr("no facet of the mesh is selected"));
  EXPECT_THAT(text, HasSubstr("point [0, 0, 0] mm, normal [-1, 0, 0]"));
}

TEST_F(Identify, InterfacesThatOverlapOrTouchAreRefused) {
  std::string same = link_text();
  const std::size_t at = same.find("loaded:");
  same.replace(at, same.find('\n', at) - at,
               "loaded: {plane: {point: [0, 0, 0], normal: [-1, 0, 0]}}");
  EXPECT_THAT(message(bar, same), HasSubstr("2 facets are in both interfaces"));
  std::string touching = link_text();
  touching.replace(at, touching.find('\n', at) - at,
                   "loaded: {plane: {point: [0, 10, 0], normal: [0, 1, 0]}}");
  EXPECT_THAT(message(bar, touching), HasSubstr("touches the fixed one"));
}

TEST_F(Identify, BrokenSurfacesAreRefusedWithCountsAndFacets) {
  SurfaceMesh open = bar;
  open.triangles.pop_back();
  EXPECT_THAT(message(open, link_text()), HasSubstr("3 open edges"));
  SurfaceMesh flipped = bar;
  std::swap(flipped.triangles[2][0], flipped.triangles[2][1]);
  EXPECT_THAT(message(flipped, link_text()), HasSubstr("1 facet faces the other way"));
  SurfaceMesh crossing = bar;
  append(crossing, box_surface({0.04, -0.002, -0.02}, {0.05, 0.002, 0.02}));
  EXPECT_THAT(message(crossing, link_text()), HasSubstr("pairs of facets cross"));
  SurfaceMesh two = bar;
  append(two, box_surface({1, 1, 1}, {1.1, 1.1, 1.1}));
  EXPECT_THAT(message(two, link_text()), HasSubstr("2 separate bodies"));
  EXPECT_THAT(message(inverted(bar), link_text()), HasSubstr("inside out"));
}

TEST_F(Identify, FieldsHaveAValueAtEveryNode) {
  const LinkResult result = run(bar, link_text());
  const io::VtuGrid grid = displacement_fields(result);
  EXPECT_EQ(grid.cell, io::VtuCell::quadratic_tetra);
  EXPECT_EQ(grid.points.size(), 3 * result.mesh.nodes.size());
  ASSERT_EQ(grid.point_fields.size(), 19u);  // three for each of six loads, and the interfaces
  EXPECT_NO_THROW(io::vtu_text(grid));
}

// Away from the ends a bar under tension has the stress force / area along it and no other.
TEST_F(Identify, StressOfTensionIsForceOverArea) {
  const LinkResult result = run(bar, link_text());
  const io::VtuGrid grid = displacement_fields(result);
  const io::VtuField &tensor = grid.point_fields[1], &equivalent = grid.point_fields[2];
  EXPECT_EQ(tensor.name, "stress Fx");
  EXPECT_EQ(equivalent.name, "von Mises Fx");
  const double expected = 1 / result.interfaces[1].geometry.area;
  const double low = result.interfaces[0].geometry.centroid.x(),
               high = result.interfaces[1].geometry.centroid.x();
  int checked = 0;
  for (std::size_t n = 0; n < result.mesh.nodes.size(); ++n) {
    const double along = (result.mesh.nodes[n].x() - low) / (high - low);
    if (along < 0.4 || along > 0.6) continue;
    ++checked;
    EXPECT_NEAR(tensor.values[6 * n] / expected, 1, 0.03);
    for (std::size_t k = 1; k < 6; ++k)
      EXPECT_NEAR(tensor.values[6 * n + k] / expected, 0, 0.03) << k;
    EXPECT_NEAR(equivalent.values[n] / expected, 1, 0.03);
  }
  EXPECT_GT(checked, 10);
}

}  // namespace
}  // namespace kinetostat::fea::identify_test
