#include "kinetostat/spatial/products.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace kinetostat::spatial {
namespace {

using Eigen::Index;

template <class Matrix>
Matrix random_matrix(Index rows, Index columns, test::Random& random) {
  Matrix matrix(rows, columns);
  for (Index j = 0; j < columns; ++j)
    for (Index i = 0; i < rows; ++i)
      matrix(i, j) = static_cast<typename Matrix::Scalar>(random.uniform(-1, 1));
  return matrix;
}

// One product after the other, each rounded, and each sum.
template <class Matrix>
Matrix by_definition(const Matrix& a, const Matrix& b) {
  Matrix sum = Matrix::Zero(a.rows(), b.cols());
  for (Index i = 0; i < a.rows(); ++i)
    for (Index j = 0; j < b.cols(); ++j)
      for (Index k = 0; k < a.cols(); ++k) {
        volatile typename Matrix::Scalar product = a(i, k) * b(k, j);
        sum(i, j) += product;
      }
  return sum;
}

// Rows and columns that fill tiles, and that do not; sums longer than what is taken at once.
TEST(Products, HaveTheDigitsOfTheirDefinition) {
  test::Random random(5);
  for (const Index rows : {0, 1, 15, 16, 17, 33, 70})
    for (const Index columns : {0, 1, 2, 3, 4, 11})
      for (const Index terms : {0, 1, 5, 512, 513, 1100}) {
        const auto a = random_matrix<Eigen::MatrixXd>(rows, terms, random);
        const auto b = random_matrix<Eigen::MatrixXd>(terms, columns, random);
        const Eigen::MatrixXd exact = by_definition(a, b);
        Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(rows, columns);
        add_product(a, b, sum);
        EXPECT_EQ(sum, exact) << rows << " " << columns << " " << terms;
        EXPECT_EQ(transposed_product(a.transpose().eval(), b), exact);
        const Eigen::MatrixXf single = a.transpose().cast<float>(), other = b.cast<float>();
        EXPECT_EQ(transposed_product(single, other),
                  by_definition<Eigen::MatrixXf>(single.transpose(), other));
      }
}

TEST(Products, TakePartsOfLargerMatrices) {
  test::Random random(6);
  const auto a = random_matrix<Eigen::MatrixXd>(40, 30, random);
  const auto b = random_matrix<Eigen::MatrixXd>(40, 20, random);
  EXPECT_EQ(
      transposed_product(a.block(3, 4, 30, 20), b.block(5, 6, 30, 7)),
      by_definition<Eigen::MatrixXd>(a.block(3, 4, 30, 20).transpose(), b.block(5, 6, 30, 7)));
}

}  // namespace
}  // namespace kinetostat::spatial
