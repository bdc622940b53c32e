#include "kinetostat/apps/helpers/petsc/multigrid.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "kinetostat/apps/helpers/petsc/matrices.h"
#include "kinetostat/apps/helpers/petsc/processes.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"

namespace kinetostat::petsc {
namespace {

constexpr int most_iterations = 200;

// Whether rows are longer than PETSc's aggregation reads (MatCreateGraph in 3.18): a reference body
// is coupled to all corners about its interface.
bool has_long_rows(Mat matrix, const fea::BlockNumbers& numbers) {
  constexpr PetscInt longest = 4096;
  PetscInt most = 0;
  for (const int block : numbers.of_bodies) {
    if (!numbers.is_own(block)) continue;
    PetscInt entries = 0;
    check(MatGetRow(matrix, 3 * block, &entries, nullptr, nullptr));
    most = std::max(most, entries);
    check(MatRestoreRow(matrix, 3 * block, &entries, nullptr, nullptr));
  }
  return largest_of_all(most) > longest;
}

// Aggregation of the corners; where rows are too long for it, of all but the reference bodies,
// which are eliminated. `bodies`: those rows, which this takes, or nothing.
void set_coarse_solver(Mat coarse, std::optional<RowsOfBodies> bodies, KSP below) {
  const std::string of = bodies ? "-mg_coarse_fieldsplit_nodes_" : "-mg_coarse_";
  const std::string options = "-mg_coarse_ksp_type preonly " + of + "ksp_type preonly " + of +
                              "pc_type gamg " + of + "mg_levels_ksp_type chebyshev " + of +
                              "mg_levels_pc_type jacobi " + of +
                              "mg_levels_ksp_max_it 3 "
                              "-mg_coarse_fieldsplit_bodies_ksp_type preonly "
                              "-mg_coarse_fieldsplit_bodies_pc_type redundant";
  check(PetscOptionsInsertString(nullptr, options.c_str()));
  check(KSPSetOperators(below, coarse, coarse));
  if (!bodies) return;
  PC corners = nullptr;
  check(KSPGetPC(below, &corners));
  check(PCSetType(corners, PCFIELDSPLIT));
  check(PCFieldSplitSetType(corners, PC_COMPOSITE_SCHUR));
  check(PCFieldSplitSetSchurFactType(corners, PC_FIELDSPLIT_SCHUR_FACT_FULL));
  check(PCFieldSplitSetSchurPre(corners, PC_FIELDSPLIT_SCHUR_PRE_FULL, nullptr));
  check(PCFieldSplitSetIS(corners, "nodes", bodies->nodes));
  check(PCFieldSplitSetIS(corners, "bodies", bodies->bodies));
  for (IS* rows : {&bodies->bodies, &bodies->nodes}) check(ISDestroy(rows));
}

KSP make_solver(Mat fine, Mat coarse, Mat prolongation, const std::optional<RowsOfBodies>& bodies,
                double tolerance) {
  // The largest eigenvalue by conjugate gradients: GMRES, the default, would keep ten vectors.
  constexpr const char* options =
      "-mg_levels_ksp_type chebyshev -mg_levels_pc_type pbjacobi -mg_levels_ksp_max_it 3 "
      "-mg_levels_esteig_ksp_type cg";
  check(PetscOptionsInsertString(nullptr, options));
  KSP solver = nullptr;
  PC multigrid = nullptr;
  check(KSPCreate(PETSC_COMM_WORLD, &solver));
  check(KSPSetOperators(solver, fine, fine));
  check(KSPSetType(solver, KSPCG));
  check(KSPSetNormType(
      solver, KSP_NORM_NATURAL));  // the energy of the error, as the preconditioner sees it
  check(KSPSetTolerances(solver, tolerance, 0, PETSC_DEFAULT, most_iterations));
  check(KSPGetPC(solver, &multigrid));
  check(PCSetType(multigrid, PCMG));
  check(PCMGSetLevels(multigrid, 2, nullptr));
  check(PCMGSetInterpolation(multigrid, 1, prolongation));
  KSP below = nullptr;
  check(PCMGGetCoarseSolve(multigrid, &below));
  set_coarse_solver(coarse, bodies, below);
  check(KSPSetFromOptions(solver));
  check(KSPSetUp(solver));
  return solver;
}

}  // namespace

Multigrid::Multigrid(ModelShare& share, double tolerance) {
  std::optional<RowsOfBodies> bodies;  // where they are to be eliminated
  {
    const fea::ModelPart part = std::move(share.part);
    const fea::P1CoarseSpace corners = p1_coarse_space(part.mesh, part.unknowns);
    prolongation_ = prolongation_of(part, corners.unknowns);
    coarse_ = stiffness_of(corners.mesh, share.materials, corners.unknowns, part.corners, MATAIJ);
    check(MatSetOption(coarse_, MAT_SPD, PETSC_TRUE));
    know_rigid_motions(coarse_, corners.mesh, corners.unknowns, part.corners);
    if (has_long_rows(coarse_, part.corners)) bodies = rows_of_bodies(coarse_, part.corners);
    fine_ = stiffness_of(part.mesh, share.materials, part.unknowns, part.fine, MATBAIJ);
  }
  common::give_back_free_memory();  // now that the mesh is gone
  solver_ = make_solver(fine_, coarse_, prolongation_, bodies, tolerance);
}

Multigrid::~Multigrid() {
  KSPDestroy(&solver_);
  for (Mat* matrix : {&fine_, &coarse_, &prolongation_}) MatDestroy(matrix);
}

Multigrid::Result Multigrid::solve(Vec load, Vec x) {
  check(KSPSetResidualHistory(solver_, nullptr, most_iterations + 1, PETSC_TRUE));
  check(KSPSolve(solver_, load, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  const PetscReal* history = nullptr;
  check(KSPGetConvergedReason(solver_, &reason));
  check(KSPGetResidualHistory(solver_, &history, &iterations));
  Result result{.converged = reason > 0, .iterations = static_cast<int>(iterations) - 1};
  if (iterations > 0 && history[0] > 0) result.residual = history[iterations - 1] / history[0];
  return result;
}

Vec Multigrid::make_vector() const {
  Vec vector = nullptr;
  check(MatCreateVecs(fine_, &vector, nullptr));
  return vector;
}

}  // namespace kinetostat::petsc
