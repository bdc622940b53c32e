#include "kinetostat/calibration/statistics/least_squares.h"

#include <cmath>
#include <limits>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace kinetostat::calibration::least_squares_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Residuals A x - b.
ResidualFunction linear(const MatrixXd& a, const VectorXd& b) {
  return [a, b](const VectorXd& x) { return Linearisation{a * x - b, a}; };
}

struct Random {
  std::mt19937 engine;
  std::normal_distribution<double> normal;
  MatrixXd matrix(Index rows, Index columns) {
    MatrixXd m(rows, columns);
    for (Index i = 0; i < rows; ++i)
      for (Index j = 0; j < columns; ++j) m(i, j) = normal(engine);
    return m;
  }
};

// The cost is least at the bound itself, to which the steps come as near as rounding lets them.
TEST(LeastSquares, AnUnknownThatApproachesItsBoundEndsOnIt) {
  const ResidualFunction towards_nought = [](const VectorXd& x) {
    const double stretched = std::expm1(x[0]) + 1e-3 * x[0] * x[0];
    return Linearisation{VectorXd::Constant(1, stretched),
                         MatrixXd::Constant(1, 1, std::exp(x[0]) + 2e-3 * x[0])};
  };
  for (const double start : {1e-6, 0.3, 1.0, 4.0}) {
    LeastSquaresOptions options;
    options.lower = VectorXd::Zero(1);
    const LeastSquaresResult result =
        minimise(towards_nought, VectorXd::Constant(1, start), options);
    EXPECT_EQ(result.x[0], 0) << start;
    EXPECT_EQ(result.hit[0], BoundHit::lower) << start;
  }
}

// Newton's steps on the arctangent overshoot from afar.
TEST(LeastSquares, AStepAfterOneInVainIsHalfAsLongAtMost) {
  std::vector<double> tried;
  const ResidualFunction arctangent = [&](const VectorXd& x) {
    tried.push_back(x[0]);
    return Linearisation{VectorXd::Constant(1, std::atan(x[0])),
                         MatrixXd::Constant(1, 1, 1 / (1 + x[0] * x[0]))};
  };
  LeastSquaresOptions options;
  options.first_damping = 0;
  const LeastSquaresResult result = minimise(arctangent, VectorXd::Constant(1, 20), options);
  EXPECT_NEAR(result.x[0], 0, 1e-12);
  double at = tried[0], in_vain = std::numeric_limits<double>::infinity();
  int shortened = 0;
  for (std::size_t i = 1; i < tried.size(); ++i) {
    const double step = std::abs(tried[i] - at);
    EXPECT_LE(step, in_vain / 2 * (1 + 1e-12)) << i;
    shortened += std::isfinite(in_vain);
    const bool better = std::abs(tried[i]) < std::abs(at);
    in_vain = better ? std::numeric_limits<double>::infinity() : step;
    if (better) at = tried[i];
  }
  EXPECT_GE(shortened, 2);
}

// Steps on x^3 take x to two thirds, and each promises all of the cost x^6.
// A guess of how far a linear model holds costs the logarithm of the way, not the way.
TEST(LeastSquares, GoesFartherWhereTheLinearModelHolds) {
  Random random{std::mt19937(3), {}};
  const MatrixXd a = random.matrix(12, 2);
  const VectorXd solution = (VectorXd(2) << 1000, -0.5).finished();
  LeastSquaresOptions options;
  options.longest_step = VectorXd::Ones(2);
  const LeastSquaresResult result = minimise(linear(a, a * solution), VectorXd::Zero(2), options);
  EXPECT_EQ(result.status, LeastSquaresStatus::converged);
  EXPECT_LT((result.x - solution).norm(), 1e-9 * solution.norm());
  EXPECT_LT(result.iterations, 16);  // 1 + 3 + 9 + ... > 1000 after seven
}

TEST(LeastSquares, EndsWhereFiveStepsInARowPromiseTooLittle) {
  const ResidualFunction cube = [](const VectorXd& x) {
    return Linearisation{VectorXd::Constant(1, std::pow(x[0], 3)),
                         MatrixXd::Constant(1, 1, 3 * x[0] * x[0])};
  };
  LeastSquaresOptions options;
  options.first_damping = 0;
  options.least_gain = 1e-4;
  const LeastSquaresResult result = minimise(cube, VectorXd::Ones(1), options);
  // (2/3)^(6 k) < 1e-4 from k = 4 on.
  EXPECT_NEAR(result.x[0], std::pow(2.0 / 3, 8), 1e-12);
  EXPECT_EQ(result.iterations, 9);
  EXPECT_EQ(result.status, LeastSquaresStatus::converged);
}

// The conditions of Karush, Kuhn and Tucker decide, whatever the bounds.
TEST(LeastSquares, BoundedProblemsMeetTheirOptimalityConditions) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    Random random{std::mt19937(seed), {}};
    const Index n = 1 + seed % 7;
    const MatrixXd a = random.matrix(n + 5, n);
    const VectorXd b = 3 * random.matrix(n + 5, 1);
    const VectorXd lower = VectorXd::Constant(n, -0.3), upper = VectorXd::Constant(n, 0.4);
    const LeastSquaresResult result =
        minimise(linear(a, b), VectorXd::Zero(n), {.lower = lower, .upper = upper});
    ASSERT_EQ(result.status, LeastSquaresStatus::converged) << seed;
    const VectorXd gradient = a.transpose() * (a * result.x - b);
    for (Index k = 0; k < n; ++k) {
      EXPECT_GE(result.x[k], lower[k]);
      EXPECT_LE(result.x[k], upper[k]);
      const BoundHit hit = result.hit[static_cast<std::size_t>(k)];
      if (hit == BoundHit::none) {
        EXPECT_NEAR(gradient[k], 0, 1e-9) << seed;
      } else {
        EXPECT_EQ(result.x[k], hit == BoundHit::lower ? lower[k] : upper[k]);
        EXPECT_GE(hit == BoundHit::lower ? gradient[k] : -gradient[k], 0) << seed;
      }
    }
  }
}

// Rosenbrock's valley with its minimum cut off: on x <= 0.5 the best is (0.5, 0.25).
// Without damping a column that is 0 says nothing of where its unknown is to go.
TEST(LeastSquares, UnknownsThatAreHeldOrHaveNoInfluenceStayWhereTheyAre) {
  Random random;
  MatrixXd a = random.matrix(8, 4);
  a.col(1).setZero();
  a.col(3).setZero();
  LeastSquaresOptions options;
  options.lower = VectorXd::Constant(4, -infinity);
  options.upper = VectorXd::Constant(4, infinity);
  VectorXd start(4);
  start << 1, 2, 3, 4;
  for (const Index held : {1, 2}) options.lower[held] = options.upper[held] = start[held];
  options.first_damping = 0;
  const LeastSquaresResult result = minimise(linear(a, random.matrix(8, 1)), start, options);
  EXPECT_EQ(result.x.tail<3>(), start.tail<3>());
  EXPECT_TRUE(std::isfinite(result.x[0]));
  EXPECT_NE(result.hit[1], BoundHit::none);
  EXPECT_NE(result.hit[2], BoundHit::none);
}

TEST(LeastSquares, FollowsACurvedValleyToABound) {
  const auto rosenbrock = [](const VectorXd& x) -> std::optional<Linearisation> {
    Linearisation at{VectorXd(2), MatrixXd(2, 2)};
    at.residual << 10 * (x[1] - x[0] * x[0]), 1 - x[0];
    at.jacobian << -20 * x[0], 10, -1, 0;
    return at;
  };
  const LeastSquaresResult all = minimise(rosenbrock, Eigen::Vector2d(-1.2, 1));
  EXPECT_LT((all.x - Eigen::Vector2d(1, 1)).norm(), 1e-12);
  const LeastSquaresResult cut = minimise(
      rosenbrock, Eigen::Vector2d(-1.2, 1),
      {.lower = Eigen::Vector2d(-infinity, -infinity), .upper = Eigen::Vector2d(0.5, infinity)});
  EXPECT_EQ(cut.status, LeastSquaresStatus::converged);
  EXPECT_EQ(cut.hit[0], BoundHit::upper);
  EXPECT_NEAR(cut.x[1], 0.25, 1e-12);
}

TEST(LeastSquares, ComesBackFromWhereTheModelHasNoAnswer) {
  // sqrt(1 - x) against 0.1: the first step of Newton's method would leave the domain.
  const auto root = [](const VectorXd& x) -> std::optional<Linearisation> {
    if (x[0] >= 1) return std::nullopt;
    const double y = std::sqrt(1 - x[0]);
    return Linearisation{VectorXd::Constant(1, y - 0.1), MatrixXd::Constant(1, 1, -0.5 / y)};
  };
  const LeastSquaresResult result = minimise(root, VectorXd::Constant(1, -8), {.first_damping = 0});
  EXPECT_NEAR(result.x[0], 0.99, 1e-10);
  const LeastSquaresResult none = minimise(root, VectorXd::Constant(1, 2));
  EXPECT_EQ(none.status, LeastSquaresStatus::no_start);
}

// Huber's location estimate of a sample solves sum psi = 0 (Huber 1964).
TEST(LeastSquares, RobustLossesBoundTheInfluenceOfOutliers) {
  const VectorXd sample = (VectorXd(7) << -0.5, -0.2, 0.1, 0.2, 0.4, 0.6, 50).finished();
  const MatrixXd ones = MatrixXd::Ones(7, 1);
  for (const Loss loss : {Loss::huber, Loss::cauchy}) {
    LeastSquaresOptions options;
    options.loss = loss;
    const LeastSquaresResult result =
        minimise(linear(ones, sample), VectorXd::Constant(1, sample.mean()), options);
    EXPECT_EQ(result.status, LeastSquaresStatus::converged);
    EXPECT_NEAR(result.weights.dot(result.at.residual), 0, 1e-6);
    EXPECT_LT(std::abs(result.x[0]), 0.5);
    EXPECT_LT(result.weights[6], 0.05);
  }
}

// Rows that are repeated are the same problem with another noise, however many they are: those of
// many rows are solved by their triangle.
TEST(LeastSquares, OfManyRowsHasTheSolutionOfTheFew) {
  constexpr Index few = 60, times = 400;
  Random random{std::mt19937(5), {}};
  const VectorXd at = random.matrix(few, 1), read = (0.7 * at).array().exp() + 1;
  const VectorXd noisy = read + 0.1 * random.matrix(few, 1);
  const auto decay = [&](Index repeats) {
    return [=](const VectorXd& x) {
      Linearisation one{(x[0] * at).array().exp() + x[1] - noisy.array(), MatrixXd(few, 2)};
      one.jacobian << at.array() * (x[0] * at).array().exp(), VectorXd::Ones(few);
      return Linearisation{one.residual.replicate(repeats, 1), one.jacobian.replicate(repeats, 1)};
    };
  };
  for (const Loss loss : {Loss::squares, Loss::huber}) {
    const LeastSquaresOptions options{.upper = VectorXd::Constant(2, 0.9), .loss = loss};
    const LeastSquaresResult short_one = minimise(decay(1), VectorXd::Zero(2), options);
    const LeastSquaresResult tall = minimise(decay(times), VectorXd::Zero(2), options);
    EXPECT_EQ(tall.status, LeastSquaresStatus::converged);
    EXPECT_LT((tall.x - short_one.x).norm(), 1e-9);
    EXPECT_EQ(tall.hit, short_one.hit);
    EXPECT_EQ(tall.hit[1], BoundHit::upper);
    EXPECT_EQ(tall.at.jacobian.rows(), few * times);
    EXPECT_NEAR(tall.cost, times * short_one.cost, 1e-9 * tall.cost);
  }
  const MatrixXd a = decay(1)(VectorXd::Zero(2)).jacobian, tall = a.replicate(times, 1);
  EXPECT_LE(condensed(tall).rows(), 8192 + 2);
  EXPECT_LT((condensed(tall).transpose() * condensed(tall) - times * a.transpose() * a).norm(),
            1e-9 * times * a.squaredNorm());
  EXPECT_LT((times * inverse_normal_matrix(tall, {0, 1}) - inverse_normal_matrix(a, {0, 1})).norm(),
            1e-10 * inverse_normal_matrix(a, {0, 1}).norm());
}

TEST(Loss, WeightIsTheDerivativeOfTheCost) {
  for (const Loss loss : {Loss::squares, Loss::huber, Loss::cauchy})
    for (const double r : {0.0, 0.3, 1.3, 1.4, -5.0, 40.0}) {
      const double h = 1e-5;
      const double slope = (cost_of(loss, r + h) - cost_of(loss, r - h)) / (2 * h);
      EXPECT_NEAR(slope, 2 * r * weight_of(loss, r), 1e-6 * (1 + std::abs(slope)));
    }
}

// Two unknowns of which only the sum matters, but for a little.
TEST(WeakCombination, IsTheDirectionThatHardlyChangesAnything) {
  MatrixXd a(3, 3);
  a << 1, 2, 0, 1, 2.001, 0, 0, 0, 5;
  const std::vector<WeakCombination> weak = weak_combinations(a, {0, 1, 2});
  ASSERT_EQ(weak.size(), 1u);
  EXPECT_GT(weak[0].condition_index, 1000);
  EXPECT_NEAR((a * weak[0].direction).norm(), 1, 1e-9);
  EXPECT_NEAR(weak[0].direction[0] / weak[0].direction[1], -2, 1e-2);
  EXPECT_NEAR(weak[0].participation[2], 0, 1e-9);
  EXPECT_TRUE(weak_combinations(a, {0, 2}).empty());
  a(1, 1) = 2;
  EXPECT_EQ(weak_combinations(a, {0, 1, 2}).at(0).condition_index, infinity);
}

// Units of the unknowns must not decide what is collinear.
TEST(WeakCombination, DoesNotDependOnUnits) {
  Random random{std::mt19937(3), {}};
  MatrixXd a = random.matrix(10, 3);
  a.col(2) = a.col(0) - 2 * a.col(1) + 1e-4 * random.matrix(10, 1);
  const auto before = weak_combinations(a, {0, 1, 2});
  a.col(1) *= 1e6;
  const auto after = weak_combinations(a, {0, 1, 2});
  ASSERT_EQ(before.size(), 1u);
  ASSERT_EQ(after.size(), 1u);
  EXPECT_NEAR(after[0].condition_index / before[0].condition_index, 1, 1e-6);
  EXPECT_NEAR(std::abs(after[0].direction[1] * 1e6 / before[0].direction[1]), 1, 1e-6);
}

TEST(NormalMatrix, InverseLeavesHeldUnknownsOut) {
  Random random{std::mt19937(4), {}};
  const MatrixXd a = random.matrix(9, 3);
  const MatrixXd inverse = inverse_normal_matrix(a, {0, 2});
  const MatrixXd part = a(Eigen::all, std::vector<Index>{0, 2});
  const MatrixXd expected = (part.transpose() * part).inverse();
  EXPECT_NEAR(inverse(0, 2), expected(0, 1), 1e-12);
  EXPECT_NEAR(inverse(2, 2), expected(1, 1), 1e-12);
  EXPECT_EQ(inverse(1, 1), 0);
}

}  // namespace
}  // namespace kinetostat::calibration::least_squares_test
