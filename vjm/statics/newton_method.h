// Newton's method for the equations of equilibrium. Internal to this module.
#pragma once

#include <optional>
#include <vector>

#include "kinetostat/vjm/statics/equilibrium_result.h"
#include "kinetostat/vjm/statics/equilibrium_system.h"
#include "kinetostat/vjm/statics/load.h"
#include "kinetostat/vjm/statics/newton_matrix.h"

namespace kinetostat::vjm {

struct NewtonTask {
  /// Without damping a step may go through a stop, from where the next one comes back to it.
  enum class Damping { as_needed, none };
  /// Once close, a matrix may be kept while each correction with it gains two digits: fewer
  /// factorisations, but corrections that fall linearly.
  enum class Matrix { renewed, kept_when_close };

  const EquilibriumOptions& options;
  bool platform_held = false;
  Damping damping = Damping::as_needed;
  Matrix matrix = Matrix::renewed;
};

struct NewtonResult {
  bool converged = false;
  bool consistent = true;  // could be solved for the first correction
  SystemState state;
  std::vector<double> corrections;  // relative to the reach
};

/// What Newton's method worked with, at or near where it ended: memory for whoever goes on there.
struct NewtonEquations {
  std::optional<EquilibriumResiduals> residuals;
  std::optional<NewtonMatrix> matrix;
};

/// From a state to one of equilibrium under the load. A damped step is accepted when the correction
/// seen from its end, with the old matrix, is smaller (Deuflhard's natural monotonicity test),
/// which does not depend on how forces and lengths are weighed. Where a law bends that test says
/// nothing; some steps there are not asked. Allocates nothing from the second correction on, but
/// where the matrix is singular.
NewtonResult newton(const EquilibriumSystem& system, const SystemState& start, const Load& load,
                    const NewtonTask& task, NewtonEquations* left = nullptr);

}  // namespace kinetostat::vjm
