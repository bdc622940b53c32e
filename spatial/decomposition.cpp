#include "kinetostat/spatial/decomposition.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace kinetostat::spatial {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigen::ColPivHouseholderQR<MatrixXd> factorised(const MatrixXd& matrix, double tolerance) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(tolerance);
  qr.compute(matrix);
  return qr;
}

}  // namespace

SymmetricEigen symmetric_eigen(const MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen tridiagonal_eigen(const VectorXd& diagonal, const VectorXd& beside) {
  Eigen::SelfAdjointEigenSolver<MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd tridiagonal_eigenvalues(const VectorXd& diagonal, const VectorXd& beside) {
  Eigen::SelfAdjointEigenSolver<MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  return solver.eigenvalues();
}

SingularValues singular_value_decomposition(const MatrixXd& matrix) {
  const Eigen::JacobiSVD<MatrixXd> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

SingularValues right_singular_vectors(const MatrixXd& matrix) {
  const Eigen::BDCSVD<MatrixXd> svd(matrix, Eigen::ComputeFullV);
  return {svd.singularValues(), {}, svd.matrixV()};
}

VectorXd singular_values(const MatrixXd& matrix) {
  return Eigen::BDCSVD<MatrixXd>(matrix).singularValues();
}

Eigen::Index rank_of(const MatrixXd& matrix, double tolerance) {
  return factorised(matrix, tolerance).rank();
}

MatrixXd range_of(const MatrixXd& matrix, double tolerance) {
  const auto qr = factorised(matrix, tolerance);
  return qr.householderQ() * MatrixXd::Identity(matrix.rows(), qr.rank());
}

MatrixXd complement_of(const MatrixXd& matrix, double tolerance) {
  const auto qr = factorised(matrix, tolerance);
  const MatrixXd q = qr.householderQ() * MatrixXd::Identity(matrix.rows(), matrix.rows());
  return q.rightCols(matrix.rows() - qr.rank());
}

MatrixXd least_squares_solution(const MatrixXd& a, const MatrixXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

MatrixXd shortest_least_squares_solution(const MatrixXd& a, const MatrixXd& b, double tolerance) {
  if (a.cols() == 0) return MatrixXd(0, b.cols());  // Eigen's solver cannot
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(tolerance);
  solver.compute(a);
  return solver.solve(b);
}

MatrixXd solve_symmetric(const MatrixXd& a, const MatrixXd& b) { return a.ldlt().solve(b); }

}  // namespace kinetostat::spatial
