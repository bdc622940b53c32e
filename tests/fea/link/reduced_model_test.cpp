#include "kinetostat/fea/link/reduced_model.h"

#include <limits>

#include <gtest/gtest.h>

#include "fea/shapes.h"

namespace kinetostat::fea::reduced_model_test {
namespace {

const Material steel(210e9, 0.3, 7850);

struct Link {
  TetMesh mesh;
  std::vector<CoupledInterface> ends;
  LinkResponse response;

  explicit Link(Coupling fixed = Coupling::rigid, Coupling loaded = Coupling::rigid)
      : mesh(box_mesh({0.1, 0.03, 0.02}, 8, 2, 2)) {
    for (Vector3& p : mesh.nodes) p += Vector3(0.1 * p.z(), 3 * p.x() * p.x(), 0.2 * p.x());
    mesh = with_mid_nodes(mesh);
    ends = coupled_ends(mesh, fixed, loaded);
    for (CoupledInterface& end : ends) end.point += Vector3(0.01, -0.02, 0.03);
    common::Progress silent;
    response = respond(mesh, {steel}, ends, {}, silent);
  }

  LinkModes modes(Support support, int count) const {
    common::Progress silent;
    return link_modes(mesh, {steel}, ends, support, count, {}, silent);
  }
};

const std::vector<std::pair<Coupling, Coupling>> couplings{
    {Coupling::rigid, Coupling::rigid},
    {Coupling::rigid, Coupling::distributing},
    {Coupling::distributing, Coupling::rigid},
    {Coupling::distributing, Coupling::distributing}};

// The rigid motion at `point` as motions of the interfaces.
Eigen::MatrixXd rigid_motions(const std::vector<CoupledInterface>& ends, const Vector3& point) {
  Eigen::MatrixXd motions(6 * static_cast<Eigen::Index>(ends.size()), 6);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    auto rows = motions.middleRows<6>(6 * static_cast<Eigen::Index>(i));
    rows.setIdentity();
    rows.topRightCorner<3, 3>() = -spatial::skew(ends[i].point - point);
  }
  return motions;
}

TEST(GuyanMass, HasTheMassTheCentreAndTheInertiaOfTheLink) {
  for (const auto& [fixed, loaded] : couplings) {
    const Link link(fixed, loaded);
    const MassProperties exact = mass_properties(link.mesh);
    const Eigen::MatrixXd mass = guyan_mass(link.mesh, {steel}, link.ends, link.response);
    const Eigen::MatrixXd motions = rigid_motions(link.ends, exact.centroid);
    const Matrix6 whole = motions.transpose() * mass * motions;
    const double kilograms = 7850 * exact.volume;
    EXPECT_LT((whole.topLeftCorner<3, 3>() - kilograms * Matrix3::Identity()).norm(),
              1e-8 * kilograms);
    EXPECT_LT((whole.topRightCorner<3, 3>()).norm(), 1e-8 * kilograms * 0.1);
    const Matrix3 about_centre = inertia(exact, 7850);
    EXPECT_LT((whole.bottomRightCorner<3, 3>() - about_centre).norm(), 1e-7 * about_centre.norm());
  }
}

// Rayleigh: fewer freedoms, higher frequencies, and all of them in the limit.
TEST(CraigBampton, ComesDownToTheFrequenciesOfTheWholeModel) {
  for (const auto& [fixed, loaded] : couplings) {
    const Link link(fixed, loaded);
    const LinkModes free = link.modes(Support::none, 4);
    double before = std::numeric_limits<double>::infinity();
    for (const int count : {0, 8, 80}) {
      const LinkModes held = count > 0 ? link.modes(Support::all_interfaces, count) : LinkModes{};
      const ReducedModel model = craig_bampton(link.mesh, {steel}, link.ends, link.response, held);
      const Eigen::VectorXd squares = natural_frequencies_squared(model.stiffness, model.mass);
      EXPECT_LT(squares.head(6).cwiseAbs().maxCoeff(), 1e-6 * squares[6]);
      for (Eigen::Index k = 0; k < 4; ++k)
        EXPECT_GT(squares[6 + k], (1 - 1e-7) * free.omega_squared[k]);
      EXPECT_LT(squares[9], before);
      before = squares[9];
    }
    EXPECT_NEAR(before, free.omega_squared[3], 2e-3 * before);
  }
}

TEST(CraigBampton, ClampsAsTheWholeModelDoes) {
  const Link link;
  const LinkModes clamped = link.modes(Support::first_interface, 3);
  const ReducedModel model = craig_bampton(link.mesh, {steel}, link.ends, link.response,
                                           link.modes(Support::all_interfaces, 30));
  const Eigen::Index size = model.mass.rows() - 6;
  const Eigen::VectorXd squares = natural_frequencies_squared(
      model.stiffness.bottomRightCorner(size, size), model.mass.bottomRightCorner(size, size));
  for (Eigen::Index k = 0; k < 3; ++k)
    EXPECT_NEAR(squares[k], clamped.omega_squared[k], 1e-3 * squares[k]);
}

}  // namespace
}  // namespace kinetostat::fea::reduced_model_test
