// How far the flexibility of a finite-element model is from the exact one, element by element.
#pragma once

#include "kinetostat/fea/elasticity/stress_recovery.h"

namespace kinetostat::fea {

/// The error of the flexibility C_ij = a(u_i, u_j). The error e of the displacements is orthogonal
/// to all displacements of the mesh, so that it is exactly a(e_i, e_j); the estimate is the
/// integral of (s*_i - s_i) : D^-1 : (s*_j - s_j), with s* the recovered stresses.
struct ErrorEstimate {
  /// Symmetric, positive semidefinite, rows and columns as those of the flexibility. To be added
  /// to it.
  Eigen::MatrixXd total;
  /// Contribution of each element, in its column: the upper triangle of the matrix column by column
  /// (00, 01, 11, 02 ...).
  Eigen::MatrixXd by_element;
  /// What the geometry may add (geometry_error.h), in `by_element` but not in `total`; empty where
  /// the mesh has no gaps.
  Eigen::MatrixXd geometry = {};
};

/// For the displacements [m] of the load cases on this mesh. The number of threads changes no
/// digit.
ErrorEstimate estimate_error(const TetMesh& mesh, const std::vector<Material>& materials,
                             const std::vector<Eigen::Matrix3Xd>& displacements,
                             common::ThreadPool& pool);

}  // namespace kinetostat::fea
