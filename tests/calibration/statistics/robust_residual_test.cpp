#include "kinetostat/calibration/statistics/robust_residual.h"

#include <gtest/gtest.h>

#include "calibration/random_matrix.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The gradient of the convex objective is zero: in b, E' psi = -e in e (what the columns take up).
void expect_optimal(const VectorXd& y, const MatrixXd& free, const MatrixXd& usual, double bend) {
  const VectorXd left = robust_residual(y, free, usual, bend, 400);
  const VectorXd psi = left.cwiseMin(bend).cwiseMax(-bend);
  EXPECT_LT((free.transpose() * psi).norm(), 1e-6 * y.norm());
  const VectorXd e = usual.transpose() * psi;
  const VectorXd rest = y - left - usual * e;  // lies in the span of the free columns
  const MatrixXd q =
      free.householderQr().householderQ() * MatrixXd::Identity(y.size(), free.cols());
  EXPECT_LT((rest - q * (q.transpose() * rest)).norm(), 1e-6 * y.norm());
}

TEST(RobustResidual, IsThatOfTheMinimum) {
  for (const Index columns : {3, 15, 60, 200}) {
    const MatrixXd free = test::random_matrix(40, 4, 1),
                   usual = test::random_matrix(40, columns, 2);
    VectorXd y = test::random_matrix(40, 1, 3).col(0) * 3;
    y[7] += 50;
    y[20] -= 400;
    SCOPED_TRACE(columns);
    expect_optimal(y, free, usual, 2);
  }
}

// Few columns or many that say no more: the same, solved in the unknowns or in the values.
TEST(RobustResidual, DoesNotDependOnHowItIsSolved) {
  const MatrixXd free = test::random_matrix(30, 3, 4), usual = test::random_matrix(30, 10, 5);
  const VectorXd y = test::random_matrix(30, 1, 6).col(0) * 10;
  MatrixXd padded = MatrixXd::Zero(30, 50);
  padded.leftCols(10) = usual;
  const VectorXd a = robust_residual(y, free, usual, 2, 8),
                 b = robust_residual(y, free, padded, 2, 8);
  EXPECT_LT((a - b).norm(), 1e-7 * a.norm());
}

TEST(RobustResidual, KeepsOutliersAsLargeAsTheyAre) {
  const MatrixXd free = MatrixXd::Ones(50, 1), usual = test::random_matrix(50, 80, 7) * 0.01;
  VectorXd y = test::random_matrix(50, 1, 8).col(0);
  y[11] = 1000;
  const VectorXd left = robust_residual(y, free, usual, 2, 20);
  EXPECT_GT(left[11], 990);
  EXPECT_LT((left.head(11)).cwiseAbs().maxCoeff(), 10);
}

TEST(RobustResidual, NeedsNoColumns) {
  const VectorXd y = test::random_matrix(20, 1, 9).col(0);
  const MatrixXd none(20, 0), usual = test::random_matrix(20, 30, 10);
  EXPECT_EQ((robust_residual(y, none, none, 2, 8) - y).norm(), 0);
  EXPECT_LT(robust_residual(y, none, usual, 2, 8).norm(), y.norm());
}

}  // namespace
}  // namespace kinetostat::calibration
