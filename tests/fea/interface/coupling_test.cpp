// Rigid, distributing and body couplings at either end of a link.
#include "kinetostat/fea/interface/coupling.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "kinetostat/fea/interface/average_motion.h"
#include "kinetostat/fea/interface/reduced_stiffness.h"
#include "kinetostat/fea/interface/stiff_body.h"
#include "kinetostat/fea/link/coupling_bracket.h"
#include "kinetostat/fea/link/link_response.h"
#include "kinetostat/fea/mesh/tetrahedralize.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/spatial/stiffness.h"

#include "fea/shapes.h"

namespace kinetostat::fea::coupling_test {
namespace {

const Material steel(210e9, 0.3);
const Coupling kinds[] = {Coupling::rigid, Coupling::body, Coupling::distributing};

TetMesh bar(int order) {
  const TetMesh linear = box_mesh({0.1, 0.02, 0.012}, 8, 2, 2);
  return order == 2 ? with_mid_nodes(linear) : linear;
}

// A short tube meshed by TetGen: held in its bore, loaded on its outside, as a bush is.
TetMesh bush() {
  const int sides = 16;
  const SurfaceMesh surface = tube_surface(0.01, 0.02, 0.015, sides);
  std::vector<int> tags;
  for (int i = 0; i < sides; ++i) tags.insert(tags.end(), {2, 2, 1, 1, 0, 0, 0, 0});
  TetrahedralizeOptions options;
  options.edge_length = 0.008;
  options.helper = KINETOSTAT_TETGEN;
  common::Progress silent;
  return with_mid_nodes(tetrahedralize(surface, tags, options, silent));
}

// A tube held on its lower end, loaded on the upper one.
TetMesh sleeve() {
  const int sides = 12;
  std::vector<int> tags;
  for (int i = 0; i < sides; ++i) tags.insert(tags.end(), {0, 0, 0, 0, 2, 2, 1, 1});
  TetrahedralizeOptions options;
  options.edge_length = 0.006;
  options.helper = KINETOSTAT_TETGEN;
  common::Progress silent;
  return with_mid_nodes(
      tetrahedralize(tube_surface(0.008, 0.012, 0.03, sides), tags, options, silent));
}

LinkResponse response(const TetMesh& mesh, Coupling fixed, Coupling loaded, double ratio = 1000) {
  std::vector<CoupledInterface> ends = coupled_ends(mesh, fixed, loaded);
  for (CoupledInterface& end : ends) end.modulus_ratio = ratio;
  common::Progress silent;
  return respond(mesh, {steel}, ends, {}, silent);
}

Matrix6 symmetric(const Matrix6& c) { return 0.5 * (c + c.transpose()); }

// Eigenvalues of D' (soft - stiff) D, ascending, where D' soft D has a diagonal of ones.
Vector6 softer_by(const Matrix6& soft, const Matrix6& stiff) {
  const Vector6 d = soft.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 scaled = d.asDiagonal() * symmetric(soft - stiff) * d.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Matrix6>(scaled).eigenvalues();
}

TEST(AverageMotion, OfARigidMotionIsThatMotion) {
  for (const TetMesh& mesh : {bar(1), bar(2), bush()})
    for (const int tag : {1, 2}) {
      const Vector3 point(0.3, -0.2, 0.4);
      const AverageMotion mean(mesh, interface_on(mesh, tag), point);
      for (int motion = 0; motion < 6; ++motion) {
        Eigen::Matrix3Xd u(3, static_cast<Eigen::Index>(mesh.nodes.size()));
        for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
          u.col(static_cast<Eigen::Index>(n)) =
              spatial::rigid_motion(mesh.nodes[n] - point) * Vector6::Unit(motion);
        EXPECT_LT((mean.of(u) - Vector6::Unit(motion)).norm(), 1e-11);
        EXPECT_LT(mean.departure(u, mean.of(u)), 1e-12);
      }
    }
}

// Uniform traction on 6-node triangles: a third of the area at each mid node, nothing at corners.
TEST(AverageMotion, AForceAtTheCentroidIsAUniformTraction) {
  const TetMesh mesh = bar(2);
  const Interface face = interface_on(mesh, 2);
  const AverageMotion mean(mesh, face, face.centroid);
  std::vector<double> expected(mesh.nodes.size(), 0);
  const double triangle = 0.02 * 0.012 / 8;
  for (const BoundaryFace& f : mesh.boundary)
    if (f.tag == 2)
      for (std::size_t k = 3; k < 6; ++k)
        expected[static_cast<std::size_t>(f.nodes[k])] += triangle / 3 / (0.02 * 0.012);
  for (std::size_t n = 0; n < mean.nodes().size(); ++n)
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 force = mean.nodal_forces().block<3, 1>(3 * static_cast<Eigen::Index>(n), axis);
      const double share = expected[static_cast<std::size_t>(mean.nodes()[n])];
      EXPECT_LT((force - share * Vector3::Unit(axis)).norm(), 1e-14);
    }
}

// The mean of a field that bends the face is not its rotation at the centre: least squares over
// the area of u = y^2 in x on a rectangle of width w gives a translation w^2 / 12 and no rotation,
// and of u = y^3 a rotation 3 w^2 / 20 against the unit slope.
TEST(AverageMotion, IsTheLeastSquaresFitOverTheArea) {
  const double width = 0.02;
  const TetMesh mesh = with_mid_nodes(box_mesh({0.1, width, 0.012}, 1, 40, 1));
  const Interface face = interface_on(mesh, 2);
  const AverageMotion mean(mesh, face, face.centroid);
  for (const int power : {2, 3}) {
    Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(mesh.nodes.size()));
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
      u(0, static_cast<Eigen::Index>(n)) = std::pow(mesh.nodes[n].y() - width / 2, power);
    const Vector6 q = mean.of(u);
    if (power == 2) {
      EXPECT_NEAR(q[0], width * width / 12, 1e-9 * width * width);
      EXPECT_NEAR(q[5], 0, 1e-9 * width);
      // The variance of y^2: w^4 (1/80 - 1/144).
      EXPECT_NEAR(mean.departure(u, q), width * width * std::sqrt(1.0 / 80 - 1.0 / 144),
                  1e-6 * width * width);
    } else {
      // A rotation r about z moves x by -r y; the cubic is fitted by its quadratic elements.
      EXPECT_NEAR(q[5], -3 * width * width / 20, 1e-4 * width * width);
      EXPECT_NEAR(q[0], 0, 1e-9 * width * width);
    }
  }
}

class Couplings : public testing::TestWithParam<const char*> {
 protected:
  TetMesh mesh() const {
    const std::string shape = GetParam();
    return shape == "bar"                      ? bar(2)
           : shape == "bar of 4-node elements" ? bar(1)
           : shape == "bush"                   ? bush()
                                               : sleeve();
  }
};
INSTANTIATE_TEST_SUITE_P(Shapes, Couplings,
                         testing::Values("bar", "bar of 4-node elements", "bush", "sleeve"));

// At either end, whatever the other end is, in every direction.
TEST_P(Couplings, RigidIsStifferThanBodyIsStifferThanDistributing) {
  const TetMesh m = mesh();
  for (const Coupling other : kinds)
    for (const bool at_fixed : {true, false}) {
      Matrix6 c[3];
      for (int k = 0; k < 3; ++k)
        c[k] =
            (at_fixed ? response(m, kinds[k], other) : response(m, other, kinds[k])).compliance();
      for (int k = 0; k < 2; ++k) {
        const Vector6 more = softer_by(c[k + 1], c[k]);
        EXPECT_GT(more.minCoeff(), -1e-9) << name(kinds[k + 1]) << " at_fixed=" << at_fixed;
        EXPECT_GT(more.maxCoeff(), 1e-9) << name(kinds[k + 1]) << " at_fixed=" << at_fixed;
      }
    }
}

TEST_P(Couplings, BodyTendsToRigidAsItsModulusGrows) {
  const TetMesh m = mesh();
  const Matrix6 rigid = response(m, Coupling::rigid, Coupling::rigid).compliance();
  double last_gap = 1e9, last_residual = 1e9;
  for (const double ratio : {1e1, 1e2, 1e3, 1e4, 1e5}) {
    const LinkResponse body = response(m, Coupling::body, Coupling::body, ratio);
    const double gap = softer_by(body.compliance(), rigid).maxCoeff();
    EXPECT_LT(gap, last_gap) << ratio;
    // In the limit the gap is proportional to the compliance of the body.
    if (ratio > 1e3) {
      EXPECT_NEAR(gap, 0.1 * last_gap, 0.01 * last_gap) << ratio;
    }
    EXPECT_LT(body.fit_residuals[1], last_residual) << ratio;
    EXPECT_GT(body.fit_residuals[1], 0);
    last_gap = gap;
    last_residual = body.fit_residuals[1];
  }
  EXPECT_EQ(response(m, Coupling::rigid, Coupling::rigid).fit_residuals,
            (std::vector<double>{0, 0}));
}

// In all nine pairs of couplings the matrix is symmetric and positive definite, the held interface
// has no mean motion, and the energy of the fields is the work of the wrenches.
TEST_P(Couplings, EveryPairIsReciprocalAndBalanced) {
  const TetMesh m = mesh();
  common::Progress silent;
  common::ThreadPool pool(2);
  const DofMap all(m, {}, {});
  const BlockMatrix k = assemble(m, {steel}, all, pool, silent);
  for (const Coupling fixed : kinds)
    for (const Coupling loaded : kinds) {
      const LinkResponse r = response(m, fixed, loaded);
      EXPECT_LT(spatial::symmetry_defect(r.compliance()), 1e-9);
      EXPECT_EQ(Eigen::LLT<Matrix6>(symmetric(r.compliance())).info(), Eigen::Success);
      const std::vector<CoupledInterface> ends = coupled_ends(m);
      const AverageMotion held(m, ends[0].geometry, ends[0].point);
      Eigen::MatrixXd u(k.size(), 6);
      for (Eigen::Index j = 0; j < 6; ++j) {
        const Eigen::Matrix3Xd& field = r.fields[static_cast<std::size_t>(j)];
        EXPECT_LT(held.of(field).norm(), 1e-10 * r.compliance().col(j).norm());
        u.col(j) = values_of(all, field);
      }
      if (fixed == Coupling::body || loaded == Coupling::body) continue;  // which store energy
      const Matrix6 energy = -u.transpose() * k.residual(Eigen::MatrixXd::Zero(k.size(), 6), u);
      const Vector6 d = r.compliance().diagonal().cwiseSqrt().cwiseInverse();
      const Matrix6 gap = d.asDiagonal() * (energy - r.compliance()) * d.asDiagonal();
      EXPECT_LT(gap.cwiseAbs().maxCoeff(), 1e-8) << name(fixed) << ' ' << name(loaded);
    }
}

// The same by Lagrange's multipliers on the whole free body, in dense algebra.
TEST(Coupling, DistributingAtBothEndsIsTheConstrainedMinimumOfTheEnergy) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.05, 0.02, 0.012}, 2, 1, 1));
  common::Progress silent;
  common::ThreadPool pool(2);
  const DofMap all(mesh, {}, {});
  const BlockMatrix sparse = assemble(mesh, {steel}, all, pool, silent);
  const Eigen::Index n = sparse.size();
  const Eigen::MatrixXd k =
      -sparse.residual(Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Identity(n, n));
  Eigen::MatrixXd g[2];
  const std::vector<CoupledInterface> ends =
      coupled_ends(mesh, Coupling::distributing, Coupling::distributing);
  for (int i = 0; i < 2; ++i) {
    const auto& end = ends[static_cast<std::size_t>(i)];
    const AverageMotion mean(mesh, end.geometry, end.point);
    g[i] = Eigen::MatrixXd::Zero(n, 6);
    for (std::size_t a = 0; a < mean.nodes().size(); ++a)
      g[i].middleRows<3>(3 * all.block_of(mean.nodes()[a])) =
          mean.nodal_forces().middleRows<3>(3 * static_cast<Eigen::Index>(a));
  }
  const double scale = k.diagonal().mean();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + 6, n + 6);
  system.topLeftCorner(n, n) = k / scale;
  system.topRightCorner(n, 6) = g[0];
  system.bottomLeftCorner(6, n) = g[0].transpose();
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(n + 6, 6);
  loads.topRows(n) = g[1] / scale;
  const Eigen::MatrixXd u = system.fullPivLu().solve(loads).topRows(n);
  const Matrix6 expected = g[1].transpose() * u;
  const Matrix6 ours = respond(mesh, {steel}, ends, {}, silent).compliance();
  const Vector6 d = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6 gap = d.asDiagonal() * (ours - expected) * d.asDiagonal();
  EXPECT_LT(gap.cwiseAbs().maxCoeff(), 1e-8);
}

// Turning the mesh turns the compliance, whatever holds it.
TEST(Coupling, ComplianceTurnsWithTheMesh) {
  const Matrix3 turn = spatial::exp_rotation(Vector3(0.4, -0.7, 1.1));
  for (const Coupling kind : kinds) {
    TetMesh mesh = bar(2);
    const Matrix6 straight = response(mesh, kind, kind).compliance();
    for (Vector3& p : mesh.nodes) p = turn * p + Vector3(1, 2, 3);
    Matrix6 both = Matrix6::Zero();
    both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = turn;
    const Matrix6 back = both.transpose() * response(mesh, kind, kind).compliance() * both;
    const Vector6 d = straight.diagonal().cwiseSqrt().cwiseInverse();
    const Matrix6 gap = d.asDiagonal() * (back - straight) * d.asDiagonal();
    EXPECT_LT(gap.cwiseAbs().maxCoeff(), 1e-8) << name(kind);
  }
}

// A prism under end loads has a closed form with distributing ends: pure tension is uniform.
TEST(Coupling, TensionBetweenDistributingEndsIsUniform) {
  const TetMesh mesh = bar(2);
  const Matrix6 c = response(mesh, Coupling::distributing, Coupling::distributing).compliance();
  EXPECT_NEAR(c(0, 0), 0.1 / (210e9 * 0.02 * 0.012), 1e-9 * c(0, 0));
  // Pure bending too: curvature M / (E I).
  EXPECT_NEAR(c(4, 4), 0.1 / (210e9 * 0.02 * std::pow(0.012, 3) / 12), 1e-9 * c(4, 4));
  EXPECT_NEAR(c(5, 5), 0.1 / (210e9 * 0.012 * std::pow(0.02, 3) / 12), 1e-9 * c(5, 5));
}

TEST(CouplingBracket, HasTheTwoExtremesAndEveryMixtureBetween) {
  const TetMesh mesh = bar(2);
  common::Progress silent;
  const std::vector<CoupledInterface> ends = coupled_ends(mesh, Coupling::rigid, Coupling::body);
  const LinkResponse mixed = respond(mesh, {steel}, ends, {}, silent);
  const CouplingBracket bracket = coupling_bracket(mesh, {steel}, ends, mixed, {}, silent);
  const Matrix6 rigid = bracket.rigid, distributing = bracket.distributing;
  const Matrix6 expected = response(mesh, Coupling::rigid, Coupling::rigid).compliance();
  EXPECT_LT((rigid - symmetric(expected)).norm(), 1e-15 * rigid.norm());
  EXPECT_GT(softer_by(mixed.compliance(), rigid).minCoeff(), -1e-9);
  EXPECT_GT(softer_by(distributing, mixed.compliance()).minCoeff(), -1e-9);
}

// The bar with a third interface: a part of its upper face, away from the ends.
TetMesh bar_with_saddle() {
  TetMesh mesh = box_mesh({0.1, 0.02, 0.012}, 8, 2, 2);
  const auto on_saddle = [&mesh](int n) {
    const Vector3& p = mesh.nodes[static_cast<std::size_t>(n)];
    return p.z() > 0.0119 && p.x() > 0.03 && p.x() < 0.07;
  };
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    for (const auto& [i, j, k] :
         {std::array<std::size_t, 3>{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}) {
      const auto tet = mesh.element(e);
      if (on_saddle(tet[i]) && on_saddle(tet[j]) && on_saddle(tet[k]))
        mesh.boundary.push_back({.nodes = {tet[i], tet[j], tet[k], -1, -1, -1}, .tag = 3});
    }
  return with_mid_nodes(mesh);
}

class SeveralInterfaces : public testing::TestWithParam<Coupling> {
 protected:
  SeveralInterfaces() : mesh(bar_with_saddle()), three(coupled_ends(mesh, GetParam(), GetParam())) {
    three.push_back({.name = "saddle",
                     .geometry = interface_on(mesh, 3),
                     .point = Vector3(0.05, 0.01, 0.02),
                     .coupling = GetParam()});
    common::Progress silent;
    flexibility = respond(mesh, {steel}, three, {}, silent).flexibility;
    scale = flexibility.diagonal().cwiseSqrt().cwiseInverse();
  }
  TetMesh mesh;
  std::vector<CoupledInterface> three;
  Eigen::MatrixXd flexibility;
  Eigen::VectorXd scale;
};
INSTANTIATE_TEST_SUITE_P(Kinds, SeveralInterfaces, testing::ValuesIn(kinds));

TEST_P(SeveralInterfaces, FlexibilityIsReciprocal) {
  ASSERT_EQ(flexibility.rows(), 12);
  const Eigen::MatrixXd defect =
      scale.asDiagonal() * (flexibility - flexibility.transpose()) * scale.asDiagonal();
  EXPECT_LT(defect.cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(SeveralInterfaces, ReducedStiffnessHasTheRigidMotionsAsItsNullSpace) {
  const Eigen::MatrixXd k = reduced_stiffness(flexibility, three);
  ASSERT_EQ(k.rows(), 18);
  EXPECT_EQ((k - k.transpose()).norm(), 0);
  Eigen::MatrixXd rigid(18, 6);
  for (std::size_t n = 0; n < 3; ++n) {
    rigid.middleRows<3>(6 * static_cast<Eigen::Index>(n)) = spatial::rigid_motion(three[n].point);
    rigid.middleRows<3>(6 * static_cast<Eigen::Index>(n) + 3) << Matrix3::Zero(),
        Matrix3::Identity();
  }
  EXPECT_LT((k * rigid).cwiseAbs().maxCoeff(), 1e-9 * k.cwiseAbs().maxCoeff());
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  EXPECT_LT(std::abs(eigenvalues[5]), 1e-10 * eigenvalues[17]);
  EXPECT_GT(eigenvalues[6], 1e3 * std::abs(eigenvalues[5]));
}

TEST_P(SeveralInterfaces, WithTheFirstOneHeldItIsTheInverseOfTheFlexibility) {
  const Eigen::MatrixXd k = reduced_stiffness(flexibility, three).bottomRightCorner(12, 12);
  const Eigen::MatrixXd one =
      scale.cwiseInverse().asDiagonal() * (k * flexibility) * Eigen::MatrixXd(scale.asDiagonal());
  EXPECT_LT((one - Eigen::MatrixXd::Identity(12, 12)).cwiseAbs().maxCoeff(), 1e-7);
}

// Which of the interfaces is held is a matter of bookkeeping.
TEST_P(SeveralInterfaces, ReducedStiffnessIsTheSameWhicheverIsHeld) {
  std::vector<CoupledInterface> turned{three[2], three[0], three[1]};
  common::Progress silent;
  const Eigen::MatrixXd other =
      reduced_stiffness(respond(mesh, {steel}, turned, {}, silent).flexibility, turned);
  const Eigen::MatrixXd k = reduced_stiffness(flexibility, three);
  const int place[] = {1, 2, 0};  // of the first, second and third in the other order
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      EXPECT_LT((k.block<6, 6>(6 * i, 6 * j) - other.block<6, 6>(6 * place[i], 6 * place[j]))
                    .cwiseAbs()
                    .maxCoeff(),
                1e-8 * k.cwiseAbs().maxCoeff());
}

// A third interface stiffens the link as far as its coupling keeps its shape: not at all when it
// is distributing.
TEST_P(SeveralInterfaces, AnUnloadedInterfaceStiffensUnlessItIsDistributing) {
  const Matrix6 two = response(mesh, GetParam(), GetParam()).compliance();
  const Vector6 more = softer_by(two, flexibility.topLeftCorner<6, 6>());
  EXPECT_GT(more.minCoeff(), -1e-9);
  if (GetParam() == Coupling::distributing)
    EXPECT_LT(more.maxCoeff(), 1e-9);
  else
    EXPECT_GT(more.maxCoeff(), 1e-3);
}

TEST(StiffBody, GrowsSoundElementsOnFlatHollowAndRoundFaces) {
  for (const TetMesh& link : {bar(1), bar(2), bush()})
    for (const int tag : {1, 2}) {
      TetMesh mesh = link;
      grow_stiff_body(mesh, interface_on(link, tag), 1);
      ASSERT_GT(mesh.element_count(), link.element_count());
      for (std::size_t e = 0; e < mesh.element_count(); ++e) {
        EXPECT_GT(volume(mesh.corners(e)), 0);
        EXPECT_EQ(mesh.material_of(e), e < link.element_count() ? 0u : 1u);
      }
      EXPECT_EQ(count_pieces(mesh), 1);
      for (std::size_t n = 0; n < link.nodes.size(); ++n) EXPECT_EQ(mesh.nodes[n], link.nodes[n]);
      // Neighbours share their middles: no two nodes lie in one place.
      for (std::size_t a = link.nodes.size(); a < mesh.nodes.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) ASSERT_GT((mesh.nodes[a] - mesh.nodes[b]).norm(), 1e-7);
    }
}

}  // namespace
}  // namespace kinetostat::fea::coupling_test
