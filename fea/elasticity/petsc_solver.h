// Models too large for one machine: p-multigrid in PETSc, the corners by its algebraic multigrid,
// on any number of processes.
#pragma once

#include <stdexcept>
#include <string>

#include <Eigen/Core>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/elasticity/assembly.h"

namespace kinetostat::fea {

/// It did not come to an end. what() says why.
class PetscFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PetscOptions {
  int processes = 1;                // above 1, `launcher` starts them
  std::string launcher = "mpirun";  // words divided by spaces; "-n" and the number follow
  double tolerance = 1e-9;          // energy of the error, its root beside the solution's
};

struct PetscSolution {
  Eigen::MatrixXd x;  // one column per load, unknowns in the order of `Unknowns`
  int iterations = 0;
  double residual = 0;
  std::size_t coarse_unknowns = 0;
  double setup_seconds = 0, solve_seconds = 0;
  double bytes = 0, largest_bytes = 0;  // at most, of all processes together and of the largest
  std::size_t most_elements = 0;        // that one process has
};

/// The helper program kinetostat-petsc is installed.
bool has_petsc();

/// Memory of all its processes together, and of the files between them and this one [bytes]; found
/// on an L-shaped foot of 3 and 10 million unknowns and on bars of 30,000 to 160,000.
double petsc_bytes(std::size_t unknowns, std::size_t columns, int processes);

/// Requires order 2 and has_petsc(). Throws PetscFailure, common::OutOfMemory, Cancelled.
PetscSolution solve_with_petsc(const TetMesh& mesh, const std::vector<Material>& materials,
                               const DofMap& unknowns, const Eigen::MatrixXd& loads,
                               const PetscOptions& options, common::Progress& progress);

}  // namespace kinetostat::fea
