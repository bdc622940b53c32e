// Comparison of matrices that says which entry differs, and by how much.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace kinetostat::test {

/// True when every entry of `actual` is within `tolerance` of the one in `expected`, absolute.
/// NaN is near to nothing. Use as EXPECT_TRUE(matrix_near(a, b, 1e-12)).
template <class A, class B>
testing::AssertionResult matrix_near(const Eigen::MatrixBase<A>& actual,
                                     const Eigen::MatrixBase<B>& expected, double tolerance) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols())
    return testing::AssertionFailure() << actual.rows() << "x" << actual.cols() << " against "
                                       << expected.rows() << "x" << expected.cols();
  for (Eigen::Index i = 0; i < actual.rows(); ++i)
    for (Eigen::Index j = 0; j < actual.cols(); ++j) {
      const double difference = actual(i, j) - expected(i, j);
      if (!(std::abs(difference) <= tolerance))
        return testing::AssertionFailure()
               << "entry (" << i << ", " << j << ") is " << actual(i, j) << ", expected "
               << expected(i, j) << ", difference " << difference << ", tolerance " << tolerance;
    }
  return testing::AssertionSuccess();
}

/// The same with the tolerance relative to the largest entry of `expected`.
template <class A, class B>
testing::AssertionResult matrix_near_relative(const Eigen::MatrixBase<A>& actual,
                                              const Eigen::MatrixBase<B>& expected,
                                              double tolerance) {
  return matrix_near(actual, expected, tolerance * expected.cwiseAbs().maxCoeff());
}

}  // namespace kinetostat::test
