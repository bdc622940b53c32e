#include "kinetostat/fea/elasticity/solver.h"

#include <cstdio>
#include <cstdlib>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/memory.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"
#include "kinetostat/fea/linear_algebra/multi_vector.h"
#include "kinetostat/fea/link/link_response.h"

#include "fea/shapes.h"

namespace kinetostat::fea::solver_test {
namespace {

const Material steel(210e9, 0.3);

std::vector<CoupledInterface> ends(const TetMesh& mesh, Coupling coupling = Coupling::rigid) {
  const Interface root = interface_on(mesh, 1), tip = interface_on(mesh, 2);
  return {{"root", root, root.centroid, coupling}, {"tip", tip, tip.centroid, coupling}};
}

LinkResponse respond_with(const SolverOptions& options, const TetMesh& mesh,
                          const std::vector<Material>& materials,
                          Coupling coupling = Coupling::rigid) {
  common::Progress silent;
  return respond(mesh, materials, ends(mesh, coupling), options, silent);
}

LinkResponse respond_with(SolverMethod method, const TetMesh& mesh,
                          const std::vector<Material>& materials,
                          Coupling coupling = Coupling::rigid, int threads = 2) {
  return respond_with({.method = method, .threads = threads}, mesh, materials, coupling);
}

// Two levels of aggregates even below small models.
SolverOptions over_aggregates(int threads = 2) {
  return {.method = SolverMethod::multigrid, .threads = threads, .most_coarse_operations = 1e4};
}

// Entry by entry beside the diagonal.
double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd scale = b.diagonal().cwiseSqrt();
  return ((a - b).array() / (scale * scale.transpose()).array()).abs().maxCoeff();
}

void expect_agreement(const LinkResponse& a, const LinkResponse& exact, double tolerance) {
  EXPECT_EQ(a.solver.method, SolverMethod::multigrid) << a.solver.reason;
  EXPECT_LT(a.solver.residual, 1e-8);
  EXPECT_LT(difference(a.flexibility, exact.flexibility), tolerance);
  for (std::size_t j = 0; j < a.fields.size(); ++j)
    EXPECT_LT((a.fields[j] - exact.fields[j]).norm(), 100 * tolerance * exact.fields[j].norm())
        << j;
}

// All methods, one answer: entries are off by at most the tolerance of 1e-8 in energy. Aggregates
// cost iterations, but not many.
void expect_agreement(const TetMesh& mesh, const std::vector<Material>& materials,
                      Coupling coupling = Coupling::rigid, double tolerance = 1e-9) {
  const LinkResponse exact = respond_with(SolverMethod::direct, mesh, materials, coupling);
  EXPECT_EQ(exact.solver.method, SolverMethod::direct);
  const LinkResponse corners = respond_with(SolverMethod::multigrid, mesh, materials, coupling);
  EXPECT_EQ(corners.solver.levels.size(), 2u);
  expect_agreement(corners, exact, tolerance);
  const LinkResponse aggregates = respond_with(over_aggregates(), mesh, materials, coupling);
  EXPECT_GE(aggregates.solver.levels.size(), 3u);
  expect_agreement(aggregates, exact, std::max(tolerance, 1e-8));
  EXPECT_LE(aggregates.solver.iterations, corners.solver.iterations * 3 / 2);
}

TEST(Solver, MultigridAgreesWithTheFactorsOnABlock) {
  expect_agreement(with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 8, 4, 4)), {steel});
}

TEST(Solver, MultigridAgreesWithTheFactorsOnASlenderRod) {
  // Bending of a rod 100 times as long as thick: stiffnesses that differ by 1e6 nearly cancel.
  expect_agreement(with_mid_nodes(box_mesh({1, 0.01, 0.01}, 150, 2, 2)), {steel}, Coupling::rigid,
                   1e-7);
}

TEST(Solver, MultigridAgreesWithTheFactorsOnAThinPlate) {
  expect_agreement(with_mid_nodes(box_mesh({0.2, 0.05, 0.002}, 40, 10, 1)), {steel},
                   Coupling::rigid, 1e-7);
}

TEST(Solver, MultigridAgreesWithTheFactorsForMaterialsOfVeryDifferentStiffness) {
  TetMesh mesh = box_mesh({0.2, 0.1, 0.1}, 8, 4, 4);
  for (std::size_t e = 0; e < mesh.element_count(); ++e)
    mesh.materials.push_back(mesh.corners(e)[0].x() > 0.1 ? 1 : 0);
  expect_agreement(with_mid_nodes(mesh), {steel, Material(210e13, 0.3)});
}

TEST(Solver, MultigridAgreesWithTheFactorsOnALinkThatSpringsHold) {
  expect_agreement(with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 8, 4, 4)), {steel},
                   Coupling::distributing);
}

TEST(Solver, EveryNumberOfThreadsGivesTheSameBytes) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 10, 5, 5));
  for (const SolverMethod method : {SolverMethod::direct, SolverMethod::multigrid}) {
    const auto one = respond_with(method, mesh, {steel}, Coupling::rigid, 1);
    for (const int threads : {2, 3, 7})
      EXPECT_TRUE(respond_with(method, mesh, {steel}, Coupling::rigid, threads).flexibility ==
                  one.flexibility)
          << name(method) << threads;
  }
  const auto one = respond_with(over_aggregates(1), mesh, {steel});
  for (const int threads : {2, 3, 7})
    EXPECT_TRUE(respond_with(over_aggregates(threads), mesh, {steel}).flexibility ==
                one.flexibility)
        << threads;
}

TEST(Solver, MoreLoadsThanLanesAreSolvedInEvenShares) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 4, 2, 2));
  const DofMap unknowns(mesh, interface_on(mesh, 1).nodes, {});
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * unknowns.blocks(), 19);
  for (Eigen::Index j = 0; j < 18; ++j) loads(3 * j, j) = 1 + static_cast<double>(j);
  common::Progress silent;
  const auto solved = [&](SolverMethod method) {
    return solve(mesh, {steel}, unknowns, loads, {.method = method, .threads = 2}, silent).x;
  };
  const Eigen::MatrixXd x = solved(SolverMethod::multigrid);
  EXPECT_EQ(x.col(18).norm(), 0);  // no load
  EXPECT_LT((x - solved(SolverMethod::direct)).norm(), 1e-8 * x.norm());
}

TEST(Solver, FollowsWithTheFactorsWhereMultigridDoesNotConverge) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 8, 4, 4));
  const std::vector<Material> nearly_incompressible{Material(1e6, 0.499999)};
  const LinkResponse a = respond_with(SolverMethod::multigrid, mesh, nearly_incompressible);
  EXPECT_EQ(a.solver.method, SolverMethod::direct);
  EXPECT_THAT(a.solver.reason, testing::HasSubstr("iterations"));
  const LinkResponse b = respond_with(SolverMethod::direct, mesh, nearly_incompressible);
  EXPECT_TRUE(a.flexibility == b.flexibility);
}

TEST(Solver, FollowsWithTheFactorsWhereAggregatesDoNotConverge) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 8, 4, 4));
  const LinkResponse a = respond_with(over_aggregates(), mesh, {Material(1e6, 0.499999)});
  EXPECT_EQ(a.solver.method, SolverMethod::direct);
  EXPECT_THAT(a.solver.reason, testing::HasSubstr("iterations"));
  EXPECT_EQ(a.solver.levels.size(), 1u);
}

TEST(Solver, AutomaticChoiceNoticesElementsTooFlatForMultigrid) {
  // Twelve times as long as thick, and more unknowns than a small model has.
  const TetMesh mesh = with_mid_nodes(box_mesh({0.264, 0.264, 0.002}, 22, 22, 2));
  const LinkResponse response = respond_with(SolverMethod::automatic, mesh, {steel});
  EXPECT_GT(response.solver.unknowns, 24000u);
  EXPECT_EQ(response.solver.method, SolverMethod::direct);
  EXPECT_THAT(response.solver.reason, testing::HasSubstr("badly shaped elements"));
  // It is seen from the pace, long before the last iteration that multigrid may take.
  const LinkResponse asked = respond_with(SolverMethod::multigrid, mesh, {steel});
  EXPECT_THAT(asked.solver.reason, testing::HasSubstr("in 100 iterations"));
  EXPECT_THAT(response.solver.reason, testing::Not(testing::HasSubstr("in 100 iterations")));
}

// A block with waves on its upper side, four cells long: mid nodes are off the middles of their
// edges, so the linear displacements are no longer among the quadratic ones.
TetMesh waved(double height) {
  TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 8, 4, 4));
  for (Vector3& p : mesh.nodes)
    p.z() += height * std::sin(std::numbers::pi * p.x() / 0.05) * p.z() / 0.1;
  mesh.curved = true;
  return mesh;
}

TEST(Solver, MultigridAgreesWithTheFactorsOnCurvedElements) {
  for (const double height : {0.004, 0.01}) expect_agreement(waved(height), {steel});
}

TEST(Solver, ElementsOfFirstOrderAreSolvedDirectly) {
  const LinkResponse response =
      respond_with(SolverMethod::multigrid, box_mesh({0.2, 0.1, 0.1}, 4, 2, 2), {steel});
  EXPECT_EQ(response.solver.method, SolverMethod::direct);
  EXPECT_THAT(response.solver.reason, testing::HasSubstr("first order"));
}

TEST(Solver, SaysThatAnUnsupportedBodyCanMove) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.4, 0.1, 0.1}, 8, 2, 2));
  const DofMap unknowns(mesh, {}, {{Vector3(0.4, 0.05, 0.05), interface_on(mesh, 2).nodes}});
  const Eigen::MatrixXd loads = Eigen::MatrixXd::Ones(3 * unknowns.blocks(), 1);
  common::Progress silent;
  for (const SolverOptions& options :
       {SolverOptions{.method = SolverMethod::direct},
        SolverOptions{.method = SolverMethod::multigrid}, over_aggregates()})
    EXPECT_THROW(solve(mesh, {steel}, unknowns, loads, options, silent), SingularStiffness);
}

TEST(Solver, RefusesAModelAboveTheMemoryLimitWithBothNumbers) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.2, 0.1, 0.1}, 8, 4, 4));
  const DofMap unknowns(mesh, interface_on(mesh, 1).nodes, {});
  const Eigen::MatrixXd loads = Eigen::MatrixXd::Ones(3 * unknowns.blocks(), 1);
  common::Progress silent;
  for (const SolverMethod method : {SolverMethod::direct, SolverMethod::multigrid}) {
    try {
      solve(mesh, {steel}, unknowns, loads, {.method = method, .memory = 1 << 20}, silent);
      ADD_FAILURE() << name(method);
    } catch (const MemoryLimit& error) {
      EXPECT_THAT(error.what(),
                  testing::ContainsRegex(std::string(name(method)) +
                                         " solver needs [0-9.]+ GiB .*, and 0.000977 GiB"));
    }
  }
}

// Ends the process: 0 when the forecast of its memory was within 10 % of the peak.
[[noreturn]] void solve_and_exit(const SolverOptions& options) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.4, 0.1, 0.1}, 32, 8, 8));
  const SolverStats stats = respond_with(options, mesh, {steel}).solver;
  const double forecast =
      stats.bytes_before +
      (options.method == SolverMethod::direct ? stats.direct.bytes : stats.multigrid.bytes);
  std::fprintf(stderr, "forecast %.0f MB, peak %.0f MB\n", forecast / 1e6, stats.peak_bytes / 1e6);
  std::_Exit(std::abs(forecast / stats.peak_bytes - 1) < 0.1 ? 0 : 1);
}

TEST(SolverDeathTest, ForecastsThePeakOfMemoryWithinTenPercent) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a fresh process, with a peak of its own
  for (const SolverOptions& options :
       {SolverOptions{.method = SolverMethod::direct, .threads = 2},
        SolverOptions{.method = SolverMethod::multigrid, .threads = 2}, over_aggregates()})
    EXPECT_EXIT(solve_and_exit(options), testing::ExitedWithCode(0), "forecast")
        << name(options.method) << options.most_coarse_operations;
}

// P'KP, column by column, is what the elements of first order give.
TEST(P1CoarseSpace, StiffnessIsThatOfLinearDisplacements) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.3, 0.1, 0.1}, 3, 1, 1));
  DofMap fine(mesh, interface_on(mesh, 1).nodes,
              {{Vector3(0.4, 0.02, 0.1), interface_on(mesh, 2).nodes}});
  fine.set_springs({{5, 1e9 * Matrix3::Identity()}});  // a free corner
  ASSERT_GE(fine.block_of(5), 0);
  const P1CoarseSpace corners = p1_coarse_space(mesh, fine);
  const Prolongation prolongation(mesh, fine, corners.unknowns);
  common::Progress silent;
  common::ThreadPool pool(2);
  const BlockMatrix k = assemble(mesh, {steel}, fine, pool, silent);
  const BlockMatrix coarse = assemble(corners.mesh, {steel}, corners.unknowns, pool, silent);
  MultiVectorProduct product(k, pool);
  MultiVector unit(static_cast<std::size_t>(coarse.size())), back(unit.size());
  MultiVector u(static_cast<std::size_t>(k.size())), f(u.size());
  const double scale = *std::max_element(coarse.value.begin(), coarse.value.end());
  for (Eigen::Index j = 0; j < coarse.size(); ++j) {
    const Eigen::VectorXd e = Eigen::VectorXd::Unit(coarse.size(), j);
    unit = to_multi_vector(e);
    prolongation.prolong(unit, u, pool);
    product(u, f, [](int) {});
    prolongation.restrict(f, back, pool);
    Eigen::VectorXd column(coarse.size());
    from_multi_vector(back, column);
    const Eigen::VectorXd expected =
        -coarse.residual(Eigen::VectorXd::Zero(coarse.size()), e).col(0);
    EXPECT_LT((column - expected).cwiseAbs().maxCoeff(), 1e-13 * scale) << j;
  }
}

TEST(MultiVectorProduct, IsTheProductOfTheMatrix) {
  const TetMesh mesh = with_mid_nodes(box_mesh({0.4, 0.1, 0.1}, 8, 4, 4));  // several pieces
  const DofMap unknowns(mesh, {}, {{Vector3(0, 0, 0), interface_on(mesh, 2).nodes}});
  common::Progress silent;
  common::ThreadPool pool(3);
  const BlockMatrix k = assemble(mesh, {steel}, unknowns, pool, silent);
  MultiVectorProduct product(k, pool);
  ASSERT_GT(product.pieces(), 2);
  Eigen::MatrixXd x(k.size(), lane_count);
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = std::sin(7.0 * double(i));
  MultiVector y(static_cast<std::size_t>(k.size()));
  std::vector<int> visits(static_cast<std::size_t>(product.pieces()), 0);
  product(to_multi_vector(x), y, [&](int piece) { ++visits[static_cast<std::size_t>(piece)]; });
  EXPECT_THAT(visits, testing::Each(1));
  Eigen::MatrixXd product_of_lanes(x.rows(), x.cols());
  from_multi_vector(y, product_of_lanes);
  const Eigen::MatrixXd expected = -k.residual(Eigen::MatrixXd::Zero(x.rows(), x.cols()), x);
  EXPECT_LT((product_of_lanes - expected).cwiseAbs().maxCoeff(),
            1e-13 * expected.cwiseAbs().maxCoeff());
}

TEST(Memory, IsFoundOnThisMachine) {
  EXPECT_GT(common::resident_memory(), 1e6);
  EXPECT_GE(common::peak_memory(), common::resident_memory());
  EXPECT_GT(common::memory_share(), common::resident_memory());
}

}  // namespace
}  // namespace kinetostat::fea::solver_test
