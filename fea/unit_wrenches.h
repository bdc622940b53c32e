// How a reference body gives way under each of the six unit wrenches.
#pragma once

#include <vector>

#include "kinetostat/fea/assembly.h"
#include "kinetostat/fea/factorisation.h"
#include "kinetostat/files/progress.h"

namespace kinetostat::fea {

struct UnitWrenchResponse {
  /// Column j: [translation; rotation] of the body's point under unit wrench j = Fx Fy Fz Mx My Mz
  /// at it, mesh axes [m/N, m/(N m); rad/N, rad/(N m)]. As computed, not made symmetric.
  Matrix6 compliance;
  /// Displacements of all nodes [m] under each unit wrench.
  std::vector<Eigen::Matrix3Xd> fields;
  FactorisationStats factorisation;
  int refinement_steps = 0;
  double solve_seconds = 0;
};

/// Solves for body number `body`. The six freedoms of the body are unknowns of the equations like
/// all others: condensing them out first would subtract large numbers from one another. Iterative
/// refinement then removes the rounding of the factorisation, which grows with the slenderness.
/// Throws SingularStiffness.
UnitWrenchResponse respond_to_unit_wrenches(const TetMesh& mesh, const Equations& equations,
                                            const Unknowns& unknowns, std::size_t body,
                                            files::Progress& progress);

}  // namespace kinetostat::fea
