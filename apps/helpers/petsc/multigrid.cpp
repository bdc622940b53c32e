#include "kinetostat/apps/helpers/petsc/multigrid.h"

#include <utility>

#include "kinetostat/apps/helpers/petsc/matrices.h"
#include "kinetostat/apps/helpers/petsc/processes.h"
#include "kinetostat/common/memory.h"
#include "kinetostat/fea/elasticity/p1_coarse_space.h"

namespace kinetostat::petsc {
namespace {

constexpr int most_iterations = 200;

KSP make_solver(Mat fine, Mat coarse, Mat prolongation, double tolerance) {
  // The largest eigenvalue by conjugate gradients: GMRES, the default, would keep ten vectors.
  constexpr const char* options =
      "-mg_levels_ksp_type chebyshev -mg_levels_pc_type pbjacobi -mg_levels_ksp_max_it 3 "
      "-mg_levels_esteig_ksp_type cg "
      "-mg_coarse_ksp_type preonly -mg_coarse_pc_type gamg "
      "-mg_coarse_mg_levels_ksp_type chebyshev -mg_coarse_mg_levels_pc_type jacobi "
      "-mg_coarse_mg_levels_ksp_max_it 3";
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
  check(KSPSetOperators(below, coarse, coarse));
  check(KSPSetFromOptions(solver));
  check(KSPSetUp(solver));
  return solver;
}

}  // namespace

Multigrid::Multigrid(ModelShare& share, double tolerance) {
  {
    const fea::ModelPart part = std::move(share.part);
    const fea::P1CoarseSpace corners = p1_coarse_space(part.mesh, part.unknowns);
    prolongation_ = prolongation_of(part, corners.unknowns);
    coarse_ = stiffness_of(corners.mesh, share.materials, corners.unknowns, part.corners, MATAIJ);
    check(MatSetOption(coarse_, MAT_SPD, PETSC_TRUE));
    know_rigid_motions(coarse_, corners.mesh, corners.unknowns, part.corners);
    fine_ = stiffness_of(part.mesh, share.materials, part.unknowns, part.fine, MATBAIJ);
  }
  common::give_back_free_memory();  // now that the mesh is gone
  solver_ = make_solver(fine_, coarse_, prolongation_, tolerance);
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
