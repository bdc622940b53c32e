// K u = f for several loads at once: the choice of the method, and what it costs.
#pragma once

#include <new>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kinetostat/common/progress.h"
#include "kinetostat/fea/elasticity/assembly.h"
#include "kinetostat/fea/elasticity/petsc_solver.h"
#include "kinetostat/fea/linear_algebra/factorisation.h"

namespace kinetostat::fea {

enum class SolverMethod {
  automatic,  // direct for small models and elements of first order, else multigrid
  direct,     // Cholesky factors of the whole matrix
  multigrid,  // conjugate gradients, preconditioned by multigrid
  petsc,      // the same in PETSc, for several processes
};

/// "automatic", "direct", "multigrid", "petsc".
const char* name(SolverMethod method);

struct SolverOptions {
  SolverMethod method = SolverMethod::automatic;
  int threads = 1;          // at least 1; no digit of the result depends on it
  double tolerance = 1e-8;  // of multigrid: energy of the error, its root beside the solution's
  /// Floating-point operations that the factors of a coarse level of multigrid may take; a level
  /// that would take more gets a level of rigid aggregates below it.
  double most_coarse_operations = 1e10;
  double memory = 0;  // [bytes] that the process may have; 0: its share of what is free
  int processes = 1;  // of petsc
  std::string launcher = "mpirun";  // that starts them when they are more than one
};

/// More memory is needed than the process may have. The message names both figures.
class MemoryLimit : public std::bad_alloc {
 public:
  MemoryLimit(SolverMethod method, double needed, double limit);
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

/// Cost of a method, as far as it is known before.
struct SolverForecast {
  double bytes = 0;    // at most at a time, beside what the process held before
  double seconds = 0;  // rough: for a processor of 2020, on the threads that it uses
};

struct SolverStats {
  SolverMethod method = SolverMethod::direct;  // the one that was used
  std::string reason;                          // why this one, in words
  SolverForecast direct, multigrid, petsc;     // zero where the method was not considered
  FactorisationStats factor;                   // of the stiffness matrix, or of the last level's
  std::size_t unknowns = 0;
  std::vector<std::size_t> levels;  // unknowns of each: all, the corners, their aggregates
  int iterations = 0;               // of conjugate gradients, or of iterative refinement
  double residual = 0;              // reached by conjugate gradients, as SolverOptions::tolerance
  double assembly_seconds = 0, setup_seconds = 0, solve_seconds = 0;  // wall clock
  double bytes_before = 0, peak_bytes = 0;                            // of the process
  /// Peaks of petsc's processes: of all together, of the largest.
  double helper_bytes = 0, largest_helper_bytes = 0;
  std::size_t most_elements = 0;  // that one of them has
};

struct Solution {
  Eigen::MatrixXd x;  // one column per load, unknowns in the order of `Unknowns`
  SolverStats stats;
};

/// Solves for all columns of `loads` (forces [N] and moments [N m] on the unknowns). The unknowns
/// of bodies are unknowns like all others: condensing them out first would subtract large numbers
/// from one another. When multigrid does not converge, or not down to the rounding, the direct
/// method follows, and the reason is in the stats. Throws SingularStiffness, MemoryLimit,
/// PetscFailure, std::bad_alloc, Cancelled.
Solution solve(const TetMesh& mesh, const std::vector<Material>& materials, const DofMap& unknowns,
               const Eigen::MatrixXd& loads, const SolverOptions& options,
               common::Progress& progress);

}  // namespace kinetostat::fea
