#include "kinetostat/fea/unit_wrenches.h"

#include <chrono>

namespace kinetostat::fea {
namespace {

constexpr int most_refinement_steps = 4;

double change(const Eigen::MatrixXd& correction, const Eigen::MatrixXd& solution) {
  return (correction.colwise().norm().array() / solution.colwise().norm().array()).maxCoeff();
}

}  // namespace

UnitWrenchResponse respond_to_unit_wrenches(const TetMesh& mesh, const Equations& equations,
                                            const Unknowns& unknowns, std::size_t body,
                                            files::Progress& progress) {
  progress.report("factorisation", 0);
  const Factorisation factorisation(equations.stiffness, equations.pattern,
                                    static_cast<int>(unknowns.bodies().size()));
  progress.report("six unit wrenches", 0);
  const auto start = std::chrono::steady_clock::now();
  const Eigen::Index first = 3 * unknowns.body_block(body);
  Eigen::MatrixXd wrenches = Eigen::MatrixXd::Zero(equations.stiffness.size(), 6);
  wrenches.middleRows<6>(first).setIdentity();

  UnitWrenchResponse response{
      .compliance = Matrix6::Zero(), .fields = {}, .factorisation = factorisation.stats()};
  Eigen::MatrixXd solution = factorisation.solve(wrenches);
  // Each step multiplies the error by about the same factor, which the last two corrections show.
  double last = 1, expected = 1;
  while (expected > 1e-14 && response.refinement_steps < most_refinement_steps) {
    const Eigen::MatrixXd correction =
        factorisation.solve(equations.stiffness.residual(wrenches, solution));
    const double now = change(correction, solution);
    if (now > 0.5 * last) break;
    solution += correction;
    ++response.refinement_steps;
    expected = now * (now / last);
    last = now;
  }
  response.compliance = solution.middleRows<6>(first);
  for (Eigen::Index j = 0; j < 6; ++j)
    response.fields.push_back(unknowns.displacements(mesh, solution.col(j)));
  response.solve_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return response;
}

}  // namespace kinetostat::fea
