#include "kinetostat/calibration/statistics/robust_residual.h"

#include <gtest/gtest.h>

#include "calibration/random_matrix.h"

namespace kinetostat::calibration::robust_residual_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The gradient of the convex objective is zero: in b, E' psi = -e in e (what the columns take up).
void expect_optimal(const VectorXd& y, const MatrixXd& free, const MatrixXd& usual, double bend) {
  const VectorXd left = robust_residual(y, free, usual, bend, 400).left;
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

// By hand: each value is left out, and predicted by the others under the same weights of one.
TEST(RobustResidual, IsSurprisedByWhatTheOthersDoNotPredict) {
  constexpr Index n = 12;
  const MatrixXd free = test::random_matrix(n, 2, 11), usual = test::random_matrix(n, 5, 12);
  const VectorXd y = test::random_matrix(n, 1, 13).col(0) * 0.5;  // all within the bend
  const VectorXd surprise = robust_residual(y, free, usual, 20, 3).surprise;
  for (Index i = 0; i < n; ++i) {
    std::vector<Index> others;
    for (Index k = 0; k < n; ++k)
      if (k != i) others.push_back(k);
    const MatrixXd b = free(others, Eigen::all), e = usual(others, Eigen::all);
    const MatrixXd s_inverse = (e * e.transpose() + MatrixXd::Identity(n - 1, n - 1)).inverse();
    const MatrixXd m = (b.transpose() * s_inverse * b).inverse();
    const VectorXd values = m * b.transpose() * s_inverse * y(others);
    const VectorXd k = e * usual.row(i).transpose();
    const double mean = free.row(i).dot(values) + k.dot(s_inverse * (y(others) - b * values));
    const VectorXd u = free.row(i).transpose() - b.transpose() * s_inverse * k;
    const double variance = 1 + usual.row(i).squaredNorm() - k.dot(s_inverse * k) + u.dot(m * u);
    EXPECT_NEAR(surprise[i], (y[i] - mean) / std::sqrt(variance), 1e-9);
  }
}

// Columns by which every value could have moved alone hide no outlier that they would need ten
// times their usual size for.
TEST(RobustResidual, SeesOutliersBesideManyColumns) {
  constexpr Index n = 50;
  const MatrixXd free = MatrixXd::Ones(n, 1);
  MatrixXd usual(n, n + 80);
  usual << MatrixXd::Identity(n, n), test::random_matrix(n, 80, 7) * 0.01;
  VectorXd y = test::random_matrix(n, 1, 8).col(0);
  y[11] = 14;
  const RobustResidual result = robust_residual(y, free, usual, 2, 20);
  EXPECT_GT(result.surprise[11], 9);
  EXPECT_LT(result.surprise.head(11).cwiseAbs().maxCoeff(), 4);
  EXPECT_LT(result.surprise.tail(38).cwiseAbs().maxCoeff(), 4);
}

TEST(RobustResidual, NeedsNoColumns) {
  const VectorXd y = test::random_matrix(20, 1, 9).col(0);
  const MatrixXd none(20, 0), usual = test::random_matrix(20, 30, 10);
  EXPECT_EQ((robust_residual(y, none, none, 2, 8).left - y).norm(), 0);
  EXPECT_LT(robust_residual(y, none, usual, 2, 8).left.norm(), y.norm());
}

}  // namespace
}  // namespace kinetostat::calibration::robust_residual_test
