#include "kinetostat/fea/link/error_bars.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace kinetostat::fea::error_bars_test {
namespace {

using Eigen::MatrixXd;

// A flexibility with one significant coupling (0, 1) and one that is not (0, 2), in mixed units.
MatrixXd exact() {
  MatrixXd c = MatrixXd::Zero(3, 3);
  c.diagonal() << 1e-8, 4e-4, 9e-2;
  c(0, 1) = c(1, 0) = 1e-6;
  c(0, 2) = c(2, 0) = 1e-7;  // 0.3 % of the root of the diagonal entries
  return c;
}

// Meshes whose error falls exactly as n^-rate; the recovery sees `seen` times the error.
std::vector<MeshOutcome> sequence(const std::vector<std::size_t>& unknowns, double rate,
                                  double seen) {
  std::vector<MeshOutcome> meshes;
  for (const std::size_t n : unknowns) {
    const MatrixXd error = 50 * std::pow(static_cast<double>(n), -rate) * exact();
    meshes.push_back({.unknowns = n,
                      .elements = n / 4,
                      .flexibility = exact() - error,
                      .recovery_error = seen * error});
  }
  return meshes;
}

double true_error(const MeshOutcome& mesh, Eigen::Index i, Eigen::Index j) {
  return exact()(i, j) - mesh.flexibility(i, j);
}

TEST(ErrorBars, FindTheRateAndTheLimitOfAConvergingSequence) {
  for (const double rate : {0.4, 0.9, 1.3}) {
    const auto meshes = sequence({1000, 5000, 12000}, rate, 1.2);
    const ErrorBars bars = error_bars(meshes, 2);
    ASSERT_TRUE(bars.observed_rate);
    EXPECT_NEAR(*bars.observed_rate, rate, 1e-6);
    ASSERT_TRUE(bars.agreement);
    EXPECT_NEAR(*bars.agreement, 1 / 1.2, 1e-6);
    EXPECT_TRUE(bars.estimates_agree());
    EXPECT_NEAR(bars.extrapolation(1, 1), true_error(meshes.back(), 1, 1), 1e-6 * exact()(1, 1));
    EXPECT_EQ(bars.convergence_is_slow(), rate < 1);
  }
}

// An error that the meshes have only started to see: its estimate does not fall.
TEST(ErrorBars, AreEnlargedWhereTheEstimateDoesNotFall) {
  auto meshes = sequence({1000, 2000}, 1.0, 1.0);
  const ErrorBars falling = error_bars(meshes, 2);
  meshes[1].recovery_error(2, 2) = meshes[0].recovery_error(2, 2);
  const ErrorBars standing = error_bars(meshes, 2);
  const double should_have_fallen = std::pow(2.0, 4.0 / 3);  // best rate of second order
  EXPECT_GT(standing.bar(2, 2),
            should_have_fallen * ErrorBars::safety * meshes[1].recovery_error(2, 2));
  EXPECT_GT(standing.bar(2, 2), 4 * falling.bar(2, 2));
  meshes[1].recovery_error(2, 2) *= 1e6;
  EXPECT_LT(error_bars(meshes, 2).bar(2, 2),
            2.2 * ErrorBars::most_unseen * ErrorBars::safety * meshes[1].recovery_error(2, 2));
}

// Where stresses are singular the recovery sees too little; the extrapolation then makes the bars.
TEST(ErrorBars, HoldTheTrueErrorWhenOneEstimateIsFarTooSmall) {
  const auto meshes = sequence({1000, 5000, 12000}, 0.5, 0.05);
  const ErrorBars bars = error_bars(meshes, 2);
  EXPECT_FALSE(bars.estimates_agree());
  for (Eigen::Index i = 0; i < 3; ++i) EXPECT_GT(bars.bar(i, i), true_error(meshes.back(), i, i));
}

// Estimates that differ by 6 instead of 3 make bars twice as wide.
TEST(ErrorBars, AreEnlargedByWhatTheEstimatesDifferTooMuch) {
  const std::vector<std::size_t> unknowns{1000, 5000, 12000};
  const ErrorBars close = error_bars(sequence(unknowns, 1, 1 / 2.999), 2);
  const ErrorBars apart = error_bars(sequence(unknowns, 1, 1 / 6.0), 2);
  EXPECT_NEAR(apart.difference(), 6, 1e-5);
  EXPECT_TRUE(close.estimates_agree());
  EXPECT_FALSE(apart.estimates_agree());
  EXPECT_TRUE(apart.estimates_are_comparable());
  EXPECT_NEAR(apart.bar(1, 1) / close.bar(1, 1), 2, 0.02);
  EXPECT_FALSE(error_bars(sequence(unknowns, 1, 1 / 11.0), 2).estimates_are_comparable());
  // The other way round: the recovery sees too much.
  EXPECT_NEAR(error_bars(sequence(unknowns, 1, 6), 2).difference(), 6, 1e-5);
}

// A sequence that starts with a very coarse mesh seems to converge faster than elements can.
TEST(ErrorBars, DoNotBelieveARateBeyondTheory) {
  const auto meshes = sequence({1000, 2000, 4000}, 4, 1);
  const ErrorBars bars = error_bars(meshes, 2);
  EXPECT_NEAR(*bars.observed_rate, 4, 1e-3);
  const double share = std::pow(2, -4.0 / 3);
  EXPECT_NEAR(bars.extrapolation(0, 0),
              share / (1 - share) * (meshes[2].flexibility - meshes[1].flexibility)(0, 0),
              1e-9 * exact()(0, 0));
}

TEST(ErrorBars, OfOneMeshRestOnTheRecoveryAlone) {
  const ErrorBars bars = error_bars(sequence({1000}, 1, 1), 2);
  EXPECT_FALSE(bars.agreement);
  EXPECT_FALSE(bars.estimates_agree());
  EXPECT_EQ(bars.extrapolation.size(), 0);
  EXPECT_NEAR(bars.bar(1, 1), 2.1 * bars.recovery(1, 1), 1e-12 * bars.recovery(1, 1));
}

TEST(ErrorBars, GrowingErrorsAreNoAgreement) {
  auto meshes = sequence({1000, 5000, 12000}, 1, 1);
  std::swap(meshes[1].flexibility, meshes[2].flexibility);
  const ErrorBars bars = error_bars(meshes, 2);
  EXPECT_FALSE(bars.observed_rate);
  EXPECT_FALSE(bars.estimates_agree());
}

// Which entries count, and how well they are known, is the same in metres and millimetres.
TEST(ErrorBars, SignificanceDoesNotDependOnUnits) {
  const auto meshes = sequence({1000, 5000, 12000}, 1, 1);
  auto scaled = meshes;
  const Eigen::Vector3d unit(1000, 0.001, 17);
  for (MeshOutcome& mesh : scaled) {
    mesh.flexibility = (unit.asDiagonal() * mesh.flexibility * unit.asDiagonal()).eval();
    mesh.recovery_error = (unit.asDiagonal() * mesh.recovery_error * unit.asDiagonal()).eval();
  }
  const ErrorBars one = error_bars(meshes, 2), other = error_bars(scaled, 2);
  EXPECT_TRUE(one.significant(0, 1));
  EXPECT_FALSE(one.significant(0, 2));
  EXPECT_EQ(one.significant, other.significant);
  EXPECT_NEAR(one.relative_error, other.relative_error, 1e-9 * one.relative_error);
}

}  // namespace
}  // namespace kinetostat::fea::error_bars_test
