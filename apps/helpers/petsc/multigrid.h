// Conjugate gradients with two-level p-multigrid: Chebyshev smoothing with 3x3 block Jacobi on the
// quadratic elements, and on the linear ones smoothed aggregation (GAMG) that knows the six rigid
// motions.
#pragma once

#include <petscksp.h>

#include "kinetostat/apps/helpers/petsc/model_share.h"

namespace kinetostat::petsc {

/// PETSc's objects for one model, released with it.
class Multigrid {
 public:
  /// Takes the share's mesh, so that it is gone before the levels of GAMG are made. `tolerance` is
  /// that of the energy of the error, its root beside the solution's.
  Multigrid(ModelShare& share, double tolerance);
  ~Multigrid();
  Multigrid(const Multigrid&) = delete;
  Multigrid& operator=(const Multigrid&) = delete;

  struct Result {
    bool converged = false;
    int iterations = 0;
    double residual = 0;  // reached, beside the load's
  };
  /// Vectors as of make_vector().
  Result solve(Vec load, Vec x);
  Vec make_vector() const;

 private:
  Mat fine_ = nullptr, coarse_ = nullptr, prolongation_ = nullptr;
  KSP solver_ = nullptr;
};

}  // namespace kinetostat::petsc
