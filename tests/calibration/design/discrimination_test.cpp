#include "kinetostat/calibration/design/discrimination.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/random.h"

namespace kinetostat::calibration::discrimination_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(kinetostat::test::Random& random, Index rows, Index columns, double size) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.uniform(-size, size); });
}

struct Case {
  Forecast a, b;
  MatrixXd common;

  explicit Case(unsigned seed) {
    kinetostat::test::Random random(seed);
    a = {random_matrix(random, 12, 1, 3), random_matrix(random, 12, 3, 2)};
    b = {random_matrix(random, 12, 1, 3), random_matrix(random, 12, 2, 2)};
    common = random_matrix(random, 12, 2, 50);
  }
  Case rows(Index first, Index count) const {
    Case part = *this;
    part.a = {a.mean.segment(first, count), a.spread.middleRows(first, count)};
    part.b = {b.mean.segment(first, count), b.spread.middleRows(first, count)};
    part.common = common.middleRows(first, count);
    return part;
  }
  Separation separation() const { return {a, b, common}; }
};

TEST(Discrimination, IsTheQuadraticFormOfTheMeanCovariance) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Case c(seed);
    const MatrixXd v =
        MatrixXd::Identity(12, 12) +
        (c.a.spread * c.a.spread.transpose() + c.b.spread * c.b.spread.transpose()) / 2 +
        c.common * c.common.transpose();
    const VectorXd d = c.a.mean - c.b.mean;
    const double expected = d.dot(v.ldlt().solve(d));
    EXPECT_NEAR(c.separation().squared(), expected, 1e-9 * expected);
  }
}

TEST(Discrimination, AddsUpOverReadings) {
  const Case c(3);
  const Separation sum = c.rows(0, 5).separation() + c.rows(5, 7).separation();
  EXPECT_NEAR(sum.squared(), c.separation().squared(), 1e-9 * sum.squared());
  EXPECT_GE(sum.squared(), c.rows(0, 5).separation().squared());
  EXPECT_EQ(Separation().squared(), 0);
}

// Readings that are confounded with an unknown parameter of either model give no information.
TEST(Discrimination, DoesNotCountWhatIsConfoundedWithAParameter) {
  Case c(4);
  c.b.mean = c.a.mean + 7 * c.a.spread.col(0);
  c.common.setZero();
  const double before = c.separation().squared();
  c.a.spread.col(0) *= 1e5;
  EXPECT_LT(c.separation().squared(), 1e-6 * before);
}

TEST(Discrimination, KnowledgeIsTheInverseOfTheInformation) {
  const Case c(5);
  Knowledge knowledge(3);
  knowledge.add(Knowledge::gain(c.a, MatrixXd(12, 0)));
  const MatrixXd covariance =
      (MatrixXd::Identity(3, 3) + c.a.spread.transpose() * c.a.spread).inverse();
  EXPECT_LT((knowledge.covariance() - covariance).norm(), 1e-12);
  EXPECT_NEAR(knowledge.mean_square(c.b.spread.replicate(1, 2).leftCols(3)),
              (c.b.spread.replicate(1, 2).leftCols(3) * covariance *
               c.b.spread.replicate(1, 2).leftCols(3).transpose())
                      .trace() /
                  12,
              1e-12);
  // Nor is it knowledge where an unknown of the session does the same.
  Forecast one{c.a.mean, c.common};
  EXPECT_LT(Knowledge::gain(one, 1e4 * c.common).norm(),
            1e-6 * (c.common.transpose() * c.common).norm());
}

TEST(Discrimination, RootOfACovarianceOfAnyUnits) {
  kinetostat::test::Random random(6);
  MatrixXd covariance = random_matrix(random, 4, 4, 1);
  covariance = covariance * covariance.transpose();
  const VectorXd units = (VectorXd(4) << 1e-9, 1, 1e6, 0).finished();
  covariance = units.asDiagonal() * covariance * units.asDiagonal();
  const MatrixXd root = root_of(covariance);
  EXPECT_LE(root.cols(), 3);
  for (Index i = 0; i < 4; ++i)
    for (Index j = 0; j < 4; ++j)
      EXPECT_NEAR((root * root.transpose())(i, j), covariance(i, j),
                  1e-12 * std::sqrt(covariance(i, i) * covariance(j, j)));
}

}  // namespace
}  // namespace kinetostat::calibration::discrimination_test
