// The matrices of a divided model: every process makes its own rows.
#pragma once

#include <petscmat.h>
#include <vector>

#include "kinetostat/fea/distribution/model_parts.h"

namespace kinetostat::petsc {

/// The stiffness of the part's own unknowns [N/m, N, N m]; columns are those of all processes.
/// MATBAIJ or MATAIJ.
Mat stiffness_of(const fea::TetMesh& mesh, const std::vector<fea::Material>& materials,
                 const fea::DofMap& unknowns, const fea::BlockNumbers& numbers, MatType type);

/// The displacements of the corners as those of all nodes. `corners` are the unknowns of
/// fea::p1_coarse_space().
Mat prolongation_of(const fea::ModelPart& part, const fea::DofMap& corners);

/// Tells the matrix the six motions of the whole model as a rigid body.
void know_rigid_motions(Mat matrix, const fea::TetMesh& mesh, const fea::DofMap& unknowns,
                        const fea::BlockNumbers& numbers);

/// The own rows of a matrix that are of reference bodies, and the others, which know the rigid
/// motions that the matrix knows.
struct RowsOfBodies {
  IS bodies = nullptr, nodes = nullptr;
};
RowsOfBodies rows_of_bodies(Mat matrix, const fea::BlockNumbers& numbers);

}  // namespace kinetostat::petsc
