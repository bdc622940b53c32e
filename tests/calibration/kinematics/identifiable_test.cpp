// Columns that a fit can determine, chosen in an order of preference.
#include "kinetostat/calibration/kinematics/identifiable.h"

#include <cmath>

#include <Eigen/SVD>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/random_matrix.h"

namespace kinetostat::calibration::identifiable_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::ElementsAre;

TEST(IndependentColumns, KeepThoseBeforeAndNameWhatTheRestIsLike) {
  MatrixXd columns = test::random_matrix(40, 5, 1);
  columns.col(2) = 3 * columns.col(0);
  columns.col(4) = columns.col(1) - columns.col(3);
  const IndependentColumns chosen = independent_columns(MatrixXd(40, 0), columns, 0, 1e-6);
  EXPECT_THAT(chosen.kept, ElementsAre(0, 1, 3));
  ASSERT_EQ(chosen.left_out.size(), 2u);
  EXPECT_EQ(chosen.left_out[0].column, 2);
  EXPECT_THAT(chosen.left_out[0].like, ElementsAre(0));
  EXPECT_FALSE(chosen.left_out[0].like_nuisance);
  EXPECT_THAT(chosen.left_out[1].like, ElementsAre(1, 3));
}

TEST(IndependentColumns, NuisanceComesFirst) {
  const MatrixXd nuisance = test::random_matrix(30, 2, 2);
  MatrixXd columns = test::random_matrix(30, 2, 3);
  columns.col(0) = nuisance * VectorXd::Ones(2);
  const IndependentColumns chosen = independent_columns(nuisance, columns, 0, 1e-6);
  EXPECT_THAT(chosen.kept, ElementsAre(1));
  EXPECT_TRUE(chosen.left_out[0].like_nuisance);
}

TEST(IndependentColumns, WhatIsBelowTheNoiseIsUnseen) {
  MatrixXd columns = test::random_matrix(30, 2, 4);
  columns.col(1) *= 0.5 / columns.col(1).norm();
  const IndependentColumns chosen = independent_columns(MatrixXd(30, 0), columns, 1, 1e-6);
  EXPECT_THAT(chosen.kept, ElementsAre(0));
  EXPECT_TRUE(chosen.left_out[0].like.empty());
}

// Two columns that are nearly one: each alone is determined, both are not; the last one goes.
TEST(DeterminedColumns, EveryUnknownThatStaysIsKnownToItsTolerance) {
  MatrixXd columns = 5 * test::random_matrix(50, 4, 5);
  columns.col(2) = columns.col(1) + 1e-2 * test::random_matrix(50, 1, 6);
  const VectorXd none = VectorXd::Zero(4);
  const IndependentColumns chosen =
      determined_columns(MatrixXd(50, 0), columns, none, 1, columns.cols());
  EXPECT_THAT(chosen.kept, ElementsAre(0, 1, 3));
  ASSERT_EQ(chosen.left_out.size(), 1u);
  EXPECT_THAT(chosen.left_out[0].like, ElementsAre(1));
  const MatrixXd kept = columns(Eigen::all, chosen.kept);
  EXPECT_LT((kept.transpose() * kept).inverse().diagonal().maxCoeff(), 1);
  // What is fixed stays, and what a prior determines.
  EXPECT_EQ(determined_columns(MatrixXd(50, 0), columns, none, 1, 1).kept.size(), 4u);
  EXPECT_EQ(determined_columns(MatrixXd(50, 0), columns, 2 * VectorXd::Ones(4), 1, 4).kept.size(),
            4u);
}

TEST(Observability, IsThatOfTheSingularValuesBesideTheNuisance) {
  const MatrixXd nuisance = test::random_matrix(30, 2, 7), columns = test::random_matrix(30, 3, 8);
  const MatrixXd projector =
      MatrixXd::Identity(30, 30) -
      nuisance * (nuisance.transpose() * nuisance).inverse() * nuisance.transpose();
  const VectorXd s = Eigen::JacobiSVD<MatrixXd>(projector * columns).singularValues();
  const ObservabilityIndices o = observability_of(nuisance, columns);
  EXPECT_NEAR(o.o1, std::cbrt(s.prod()) / std::sqrt(30), 1e-12);
  EXPECT_NEAR(o.o2, s[2] / s[0], 1e-12);
  EXPECT_NEAR(o.condition(), s[0] / s[2], 1e-10);
  EXPECT_NEAR(o.o3, s[2], 1e-12);
  EXPECT_NEAR(o.o4, s[2] * s[2] / s[0], 1e-12);
  EXPECT_NEAR(o.o5, 3 / (1 / s[0] + 1 / s[1] + 1 / s[2]), 1e-12);
  EXPECT_EQ(o.unknowns, 3);
  EXPECT_EQ(o.equations, 30);
}

}  // namespace
}  // namespace kinetostat::calibration::identifiable_test
