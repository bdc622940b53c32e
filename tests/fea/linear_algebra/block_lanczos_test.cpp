#include "kinetostat/fea/linear_algebra/block_lanczos.h"

#include <algorithm>
#include <functional>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

namespace kinetostat::fea::block_lanczos_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Symmetric, with these eigenvalues.
MatrixXd with_eigenvalues(const VectorXd& values) {
  const MatrixXd random = MatrixXd::Random(values.size(), values.size());
  const MatrixXd basis =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(random + random.transpose()).eigenvectors();
  return basis * values.asDiagonal() * basis.transpose();
}

Product by(const MatrixXd& matrix) {
  return [matrix](const MatrixXd& x) -> MatrixXd { return matrix * x; };
}

EigenPairs largest(const MatrixXd& a, const MatrixXd& m, int count, LanczosOptions options = {}) {
  common::Progress silent;
  return largest_eigenpairs(by(a), by(m), a.rows(), count, options, silent);
}

void expect_pairs(const MatrixXd& a, const MatrixXd& m, const EigenPairs& pairs) {
  for (Index k = 0; k < pairs.values.size(); ++k) {
    const VectorXd x = pairs.vectors.col(k);
    EXPECT_LT((a * (m * x) - pairs.values[k] * x).norm(), 1e-7 * pairs.values[k] * x.norm()) << k;
  }
  const MatrixXd unit = pairs.vectors.transpose() * m * pairs.vectors;
  EXPECT_LT((unit - MatrixXd::Identity(unit.rows(), unit.cols())).norm(), 1e-10);
}

// Against a dense solver, for K x = x M x / theta.
TEST(BlockLanczos, FindsTheLowestPairsOfAGeneralProblem) {
  const MatrixXd k = with_eigenvalues(VectorXd::LinSpaced(120, 1, 1e4)),
                 m = with_eigenvalues(VectorXd::LinSpaced(120, 0.5, 3));
  const MatrixXd flexibility = k.inverse();
  const EigenPairs pairs = largest(flexibility, m, 10);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> dense(k, m);
  for (Index i = 0; i < 10; ++i)
    EXPECT_NEAR(1 / pairs.values[i], dense.eigenvalues()[i], 1e-10 * dense.eigenvalues()[i]);
  expect_pairs(flexibility, m, pairs);
}

TEST(BlockLanczos, FindsEqualEigenvaluesAsOftenAsTheyAre) {
  VectorXd values = VectorXd::LinSpaced(200, 1, 0.001);
  values.segment(2, 7).setConstant(0.97);
  values.segment(9, 2).setConstant(0.96);
  std::sort(values.begin(), values.end(), std::greater<>());
  const MatrixXd unit = MatrixXd::Identity(200, 200);
  const EigenPairs pairs = largest(with_eigenvalues(values), unit, 12);
  for (Index i = 0; i < 12; ++i) EXPECT_NEAR(pairs.values[i], values[i], 1e-12) << i;
}

TEST(BlockLanczos, GoesOnFromTheBestWhenItsColumnsAreUsedUp) {
  const VectorXd values = VectorXd::LinSpaced(400, 1, 0.1);  // badly separated
  const MatrixXd a = with_eigenvalues(values), unit = MatrixXd::Identity(400, 400);
  const EigenPairs pairs = largest(a, unit, 6, {.most_columns = 40});
  for (Index i = 0; i < 6; ++i) EXPECT_NEAR(pairs.values[i], values[i], 1e-10) << i;
  expect_pairs(a, unit, pairs);
}

TEST(BlockLanczos, GivesWhatThereIsWhereTheMassHasFewDirections) {
  VectorXd masses = VectorXd::Zero(50);
  masses.head(5) << 5, 4, 3, 2, 1;
  const MatrixXd unit = MatrixXd::Identity(50, 50);
  const EigenPairs pairs = largest(unit, MatrixXd(masses.asDiagonal()), 8);
  ASSERT_EQ(pairs.values.size(), 5);
  EXPECT_LT((pairs.values - masses.head(5)).norm(), 1e-12);
}

TEST(BlockLanczos, SaysWhenItDoesNotConverge) {
  const MatrixXd a = with_eigenvalues(VectorXd::LinSpaced(400, 1, 0.1));
  EXPECT_THROW(largest(a, MatrixXd::Identity(400, 400), 6, {.most_blocks = 2}),
               common::NoConvergence);
}

}  // namespace
}  // namespace kinetostat::fea::block_lanczos_test
