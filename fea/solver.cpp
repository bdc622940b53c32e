#include "kinetostat/fea/solver.h"

#include <chrono>
#include <limits>

namespace kinetostat::fea {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int most_refinement_steps = 4;

double change(const Eigen::MatrixXd& correction, const Eigen::MatrixXd& solution) {
  const double smallest = std::numeric_limits<double>::min();  // a load of zero moves nothing
  return (correction.colwise().norm().array() / solution.colwise().norm().array().max(smallest))
      .maxCoeff();
}

// Each step multiplies the error by about the same factor, which the last two corrections show.
int refine(const SymmetricMatrix& stiffness, const Factorisation& factorisation,
           const Eigen::MatrixXd& loads, Eigen::MatrixXd& x) {
  int steps = 0;
  double last = 1, expected = 1;
  while (expected > 1e-14 && steps < most_refinement_steps) {
    const Eigen::MatrixXd correction = factorisation.solve(stiffness.residual(loads, x));
    const double now = change(correction, x);
    if (now > 0.5 * last) break;
    x += correction;
    ++steps;
    expected = now * (now / last);
    last = now;
  }
  return steps;
}

Solution solve_directly(const Equations& equations, const Unknowns& unknowns,
                        const Eigen::MatrixXd& loads, files::Progress& progress) {
  progress.report("factorisation", 0);
  const Factorisation factorisation(equations.stiffness, equations.pattern,
                                    static_cast<int>(unknowns.bodies().size()));
  progress.report("solution", 0);
  Solution solution{.x = factorisation.solve(loads), .stats = {}};
  solution.stats.method = "supernodal Cholesky, nested dissection";
  solution.stats.factor = factorisation.stats();
  solution.stats.iterations = refine(equations.stiffness, factorisation, loads, solution.x);
  return solution;
}

}  // namespace

Solution solve(const TetMesh& /*mesh*/, const Equations& equations, const Unknowns& unknowns,
               const Eigen::MatrixXd& loads, const SolverOptions& /*options*/,
               files::Progress& progress) {
  const auto start = Clock::now();
  Solution solution = solve_directly(equations, unknowns, loads, progress);
  solution.stats.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return solution;
}

}  // namespace kinetostat::fea
