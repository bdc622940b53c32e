// Decompositions of dense matrices, compiled once for all who use them.
#pragma once

#include <Eigen/Core>

namespace kinetostat::spatial {

/// A = V diag(values) V', A symmetric; values ascending, columns of V orthonormal.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);
/// Of the tridiagonal matrix with these entries.
SymmetricEigen tridiagonal_eigen(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside);
/// Its values alone, which cost the square of its size and not the cube.
Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal,
                                        const Eigen::VectorXd& beside);

/// A = U diag(values) V', values descending, U and V square and orthogonal. By Jacobi's method:
/// small singular values are as exact as large ones.
struct SingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd u, v;
};
SingularValues singular_value_decomposition(const Eigen::MatrixXd& matrix);
/// Of larger matrices, by division: without U.
SingularValues right_singular_vectors(const Eigen::MatrixXd& matrix);
/// The values alone, by division, descending.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& matrix);

/// Numerical rank: pivots below `tolerance` times the largest count as zero.
Eigen::Index rank_of(const Eigen::MatrixXd& matrix, double tolerance);
/// Orthonormal columns that span the range of a matrix.
Eigen::MatrixXd range_of(const Eigen::MatrixXd& matrix, double tolerance);
/// Orthonormal columns that span what is orthogonal to the range of a matrix.
Eigen::MatrixXd complement_of(const Eigen::MatrixXd& matrix, double tolerance);

/// x with the least |A x - b|, by an orthogonal factor with pivots; A of full rank.
Eigen::MatrixXd least_squares_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// The shortest of all x with the least |A x - b|.
Eigen::MatrixXd shortest_least_squares_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                                double tolerance);
/// A^-1 b, A symmetric and positive semi-definite.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace kinetostat::spatial
