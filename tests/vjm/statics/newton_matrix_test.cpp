// The Newton matrix factorised in two ways, against itself and against differences of the
// residuals.
#include "kinetostat/vjm/statics/newton_matrix.h"

#include <random>

#include <gtest/gtest.h>

#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm::newton_matrix_test {
namespace {

using Eigen::VectorXd;

struct Loaded {
  Manipulator manipulator;
  Posture posture;
  Load load;
};

Loaded loaded(const std::string& name) {
  Manipulator manipulator =
      read_robot(std::string(KINETOSTAT_SOURCE_DIR) + "/data/robots/" + name).manipulator;
  Posture posture = posture_from_joints(manipulator, {}).posture;
  return {std::move(manipulator),
          std::move(posture),
          {.force = {300, -200, 100}, .moment = {5, -3, 8}}};
}

SystemVector random_vector(const EquilibriumSystem& system, bool held, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  VectorXd flat = system.flat(system.zero(), held);
  for (double& value : flat) value = uniform(engine);
  return system.from_flat(flat, held);
}

class NewtonMatrixOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(ArmParallelRobotAndMechanism, NewtonMatrixOf,
                         ::testing::Values("six_axis.yaml", "orthoglide.yaml", "delta.yaml",
                                           "orthoglide_prpar.yaml"),
                         [](const auto& test) {
                           const std::string name = test.param;
                           return name.substr(0, name.find('.'));
                         });

// Chain by chain, or all at once: the same solution, and one of the equations.
TEST_P(NewtonMatrixOf, IsSolvedTheSameChainByChainAndAsAWhole) {
  const Loaded robot = loaded(GetParam());
  const EquilibriumSystem system(robot.manipulator, robot.posture);
  const EquilibriumResiduals at(system, system.relaxed_state(), robot.load);
  if (system.has_rigid_directions()) return;  // which chain by chain is not for
  for (const bool held : {false, true}) {
    const SystemVector right = at.newton_right_hand_side(held);
    SystemVector chainwise, whole;
    EXPECT_TRUE(ChainwiseFactor(at, held).solve(right, chainwise));
    EXPECT_TRUE(WholeFactor(at, held).solve(right, whole));
    const VectorXd a = system.flat(chainwise, held), b = system.flat(whole, held);
    EXPECT_LE((a - b).norm(), 1e-9 * b.norm()) << held;
    const VectorXd r = system.flat(right, held);
    EXPECT_LE((EquilibriumTangent(at).matrix(held) * b - r).norm(), 1e-10 * r.norm()) << held;
  }
}

// An arm reduced to its coordinates, under a load that turns with it: the same solution as a whole.
TEST(SerialFactor, IsSolvedAsAWhole) {
  Loaded robot = loaded("six_axis.yaml");
  robot.load.point_on_platform = {0.1, -0.2, 0.3};
  const EquilibriumSystem system(robot.manipulator, robot.posture);
  ASSERT_TRUE(SerialFactor::can_factorise(system, false));
  EXPECT_FALSE(SerialFactor::can_factorise(system, true));
  const SystemVector step = random_vector(system, false, 3);
  const SystemState state = system.moved(system.relaxed_state(), step, 1e-3);
  const EquilibriumResiduals at(system, state, robot.load);
  ASSERT_FALSE(at.load_matrix().isZero(0));
  for (unsigned seed = 4; seed < 8; ++seed) {
    const SystemVector right = random_vector(system, false, seed);
    SystemVector reduced, whole;
    EXPECT_TRUE(SerialFactor(at).solve(right, reduced));
    EXPECT_TRUE(WholeFactor(at, false).solve(right, whole));
    const VectorXd a = system.flat(reduced, false), b = system.flat(whole, false);
    EXPECT_LE((a - b).norm(), 1e-9 * b.norm());
  }
}

// Of minus the residuals it is minus the derivative, wherever the chains meet the bodies.
TEST_P(NewtonMatrixOf, IsTheDerivativeOfTheResiduals) {
  const Loaded robot = loaded(GetParam());
  const EquilibriumSystem system(robot.manipulator, robot.posture);
  SystemVector wrenches = random_vector(system, false, 1);
  wrenches.bodies.setZero();
  for (VectorXd& x : wrenches.coordinates) x.setZero();
  const SystemState state = system.moved(system.relaxed_state(), wrenches, 1e-3);
  EquilibriumResiduals at(system, state, robot.load);
  const Eigen::MatrixXd matrix = EquilibriumTangent(at).matrix(false);
  for (unsigned seed = 2; seed < 8; ++seed) {
    SystemVector step = random_vector(system, false, seed);
    for (std::size_t c = 0; c < system.chains().size(); ++c)
      for (const Eigen::Index k : at.chains()[c].held()) step.coordinates[c][k] = 0;
    const double h = 1e-5;
    const auto residuals = [&](double factor) {
      at.move_to(system.moved(state, step, factor));
      return system.flat(at.newton_right_hand_side(false), false);
    };
    const VectorXd numerical = (residuals(-h) - residuals(h)) / (2 * h);
    const VectorXd exact = matrix * system.flat(step, false);
    EXPECT_LT((numerical - exact).norm(), 1e-6 * exact.norm()) << seed;
  }
}

// What was factorised stays at its state when the residuals move on, until it is renewed.
TEST(NewtonMatrix, StaysWhereItIsUntilRenewed) {
  const Loaded robot = loaded("delta.yaml");
  const EquilibriumSystem system(robot.manipulator, robot.posture);
  const SystemState relaxed = system.relaxed_state();
  const SystemState moved = system.moved(relaxed, random_vector(system, false, 5), 1e-3);
  const SystemVector right = random_vector(system, false, 6);
  const auto solution = [&](const NewtonMatrix& matrix) {
    SystemVector solved;
    matrix.solve(right, solved);
    return system.flat(solved, false);
  };
  EquilibriumResiduals at(system, relaxed, robot.load);
  NewtonMatrix matrix(at, false);
  const VectorXd before = solution(matrix);
  at.move_to(moved);
  EXPECT_EQ(solution(matrix), before);
  matrix.renew(at);
  EXPECT_EQ(solution(matrix),
            solution(NewtonMatrix(EquilibriumResiduals(system, moved, robot.load), false)));
  EXPECT_NE(solution(matrix), before);
}

}  // namespace
}  // namespace kinetostat::vjm::newton_matrix_test
