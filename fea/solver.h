// K u = f for several loads at once: the choice of the method, and what it cost.
#pragma once

#include <string>

#include <Eigen/Core>

#include "kinetostat/fea/assembly.h"
#include "kinetostat/fea/factorisation.h"
#include "kinetostat/files/progress.h"

namespace kinetostat::fea {

struct SolverOptions {
  enum class Method { automatic, direct };
  Method method = Method::automatic;
  int threads = 1;
};

struct SolverStats {
  std::string method;         // in words
  FactorisationStats factor;  // of the stiffness matrix
  int iterations = 0;         // steps of iterative refinement
  double seconds = 0;         // wall clock, all of it
};

struct Solution {
  Eigen::MatrixXd x;  // one column per load, unknowns in the order of `Unknowns`
  SolverStats stats;
};

/// Solves for all columns of `loads` (forces [N] and moments [N m] on the unknowns). The unknowns
/// of bodies are unknowns like all others: condensing them out first would subtract large numbers
/// from one another. Iterative refinement removes the rounding of the factorisation, which grows
/// with the slenderness. Throws SingularStiffness, std::bad_alloc, Cancelled.
Solution solve(const TetMesh& mesh, const Equations& equations, const Unknowns& unknowns,
               const Eigen::MatrixXd& loads, const SolverOptions& options,
               files::Progress& progress);

}  // namespace kinetostat::fea
