#include "kinetostat/fea/link/geometric_stiffness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>

#include "kinetostat/common/index.h"
#include "kinetostat/fea/elasticity/prestress.h"
#include "kinetostat/fea/linear_algebra/factorisation.h"
#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/spatial/stiffness.h"

namespace kinetostat::fea {
namespace {

using common::at;

constexpr const char* phase = "geometric stiffness";

Eigen::Matrix3Xd combined(const std::vector<Eigen::Matrix3Xd>& fields, const Vector6& weights) {
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, fields.front().cols());
  for (std::size_t j = 0; j < 6; ++j) sum += weights[static_cast<Eigen::Index>(j)] * fields[j];
  return sum;
}

// The fields of the six unit motions of the loaded interface: under the wrenches that make them.
std::vector<Eigen::Matrix3Xd> unit_motions(const LinkResponse& response, const Matrix6& stiffness) {
  std::vector<Eigen::Matrix3Xd> motions;
  for (Eigen::Index k = 0; k < 6; ++k)
    motions.push_back(combined(response.fields, stiffness.col(k)));
  return motions;
}

// Second derivative of the stress energy in the unit motions, with the nodes in between following
// as without stress.
Matrix6 projected(const TetMesh& mesh, const ReferenceBody& body, const Prestress& prestress,
                  const std::vector<Eigen::Matrix3Xd>& motions) {
  Matrix6 result;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const Eigen::Matrix3Xd forces = prestress.times(motions[at(k)]);
    for (Eigen::Index l = 0; l < 6; ++l) result(l, k) = motions[at(l)].cwiseProduct(forces).sum();
  }
  result.bottomRightCorner<3, 3>() += body_stress_stiffness(mesh, body, prestress.nodal_forces());
  return 0.5 * (result + result.transpose());
}

// The equations of the link with K factorised, and the product with K_sigma.
class StressedModel {
 public:
  StressedModel(const TetMesh& mesh, const std::vector<Material>& materials, DofMap unknowns,
                const Prestress& prestress, common::Progress& progress)
      : unknowns_(std::move(unknowns)),
        factors_(stiffness(mesh, materials, unknowns_, progress),
                 static_cast<int>(unknowns_.bodies().size())),
        prestress_(mesh, unknowns_, prestress) {}

  Eigen::Index size() const { return Eigen::Index{3} * unknowns_.blocks(); }
  const PrestressProduct& prestress() const { return prestress_; }
  Eigen::VectorXd solve(const Eigen::VectorXd& load) const { return factors_.solve(load); }

 private:
  static BlockMatrix stiffness(const TetMesh& mesh, const std::vector<Material>& materials,
                               const DofMap& unknowns, common::Progress& progress) {
    common::ThreadPool alone(1);
    return assemble(mesh, materials, unknowns, alone, progress);
  }

  DofMap unknowns_;
  Factorisation factors_;
  PrestressProduct prestress_;
};

// Largest eigenvalue of K x m = -K_sigma x by Lanczos' method in the inner product of K, with full
// reorthogonalisation; 0 when none is positive. Its reciprocal is the smallest buckling factor.
double largest_reciprocal_factor(const StressedModel& model, common::Progress& progress) {
  constexpr int most_steps = 80;
  constexpr double tolerance = 1e-9;
  std::mt19937_64 random(1);  // any start that has a share of every mode
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::VectorXd force =
      Eigen::VectorXd::NullaryExpr(model.size(), [&] { return uniform(random); });
  const int steps = static_cast<int>(std::min<Eigen::Index>(most_steps, model.size()));
  Eigen::MatrixXd basis(model.size(), steps), forces(model.size(), steps);  // v and K v
  Eigen::VectorXd diagonal(steps), beside(steps);
  double last = 0;
  for (int k = 0; k < steps; ++k) {
    progress.report(phase, static_cast<double>(k) / most_steps);
    Eigen::VectorXd vector = model.solve(force);
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd shares = forces.leftCols(k).transpose() * vector;
      vector -= basis.leftCols(k) * shares;
      force -= forces.leftCols(k) * shares;
    }
    const double length = std::sqrt(std::max(vector.dot(force), 0.0));
    if (k > 0) beside[k - 1] = length;
    if (k > 0 && !(length > 1e-12 * diagonal.head(k).cwiseAbs().maxCoeff())) return last;
    basis.col(k) = vector / length;
    forces.col(k) = force / length;
    force = -(model.prestress() * basis.col(k));
    diagonal[k] = basis.col(k).dot(force);
    const spatial::SymmetricEigen eigen =
        spatial::tridiagonal_eigen(diagonal.head(k + 1), beside.head(k));
    const double largest = eigen.values[k], share = eigen.vectors(k, k);
    // The residual of the pair is at most the next off-diagonal entry times this share.
    if (k > 8 && std::abs(largest - last) < tolerance * std::abs(largest) && std::abs(share) < 1e-4)
      return std::max(largest, 0.0);
    last = std::max(largest, 0.0);
  }
  return last;
}

double buckling_factor(const StressedModel& model, common::Progress& progress) {
  const double reciprocal = largest_reciprocal_factor(model, progress);
  return reciprocal > 0 ? 1 / reciprocal : std::numeric_limits<double>::infinity();
}

// (K + K_sigma)^-1 load by conjugate gradients on top of the factors of K. Below buckling the
// matrix is positive definite, and few of its eigenvalues are far from those of K.
Eigen::VectorXd solve_stressed(const StressedModel& model, const Eigen::VectorXd& load,
                               common::Progress& progress) {
  constexpr int most_steps = 300;
  constexpr double tolerance = 1e-12;  // of the energy of the error
  Eigen::VectorXd x = Eigen::VectorXd::Zero(model.size()), rest = load, z = model.solve(rest),
                  p = z, stiffness_p = rest;  // K p
  double rho = rest.dot(z);
  const double first = rho;
  for (int step = 0; step < most_steps && rho > tolerance * tolerance * first; ++step) {
    progress.report(phase, 0);
    const Eigen::VectorXd product = stiffness_p + model.prestress() * p;
    const double alpha = rho / p.dot(product);
    x += alpha * p;
    rest -= alpha * product;
    z = model.solve(rest);
    const double next = rest.dot(z);
    p = z + next / rho * p;
    stiffness_p = rest + next / rho * stiffness_p;
    rho = next;
  }
  return x;
}

// What the nodes between the interfaces give way to the stress: -F' (K + K_sigma)^-1 F with the
// forces F of the stress in the unit motions.
Matrix6 relaxation(const StressedModel& held, const Prestress& prestress,
                   const std::vector<Eigen::Matrix3Xd>& motions, common::Progress& progress) {
  Eigen::MatrixXd forces(held.size(), 6), answer(held.size(), 6);
  for (Eigen::Index k = 0; k < 6; ++k) {
    forces.col(k) = held.prestress().on_unknowns(prestress.times(motions[at(k)]));
    answer.col(k) = solve_stressed(held, forces.col(k), progress);
  }
  const Matrix6 result = -forces.transpose() * answer;
  return 0.5 * (result + result.transpose());
}

DofMap with_both_held(const TetMesh& mesh, const std::vector<CoupledInterface>& interfaces) {
  std::vector<int> nodes = interfaces[0].geometry.nodes;
  nodes.insert(nodes.end(), interfaces[1].geometry.nodes.begin(),
               interfaces[1].geometry.nodes.end());
  return DofMap(mesh, nodes, {});
}

}  // namespace

BeyondBuckling::BeyondBuckling(double factor)
    : std::runtime_error(fmt::format(
          "the link buckles at {:.4g} times the preload, even with both interfaces held", factor)) {
}

GeometricStiffness geometric_stiffness(const TetMesh& mesh, const std::vector<Material>& materials,
                                       const std::vector<CoupledInterface>& interfaces,
                                       const LinkResponse& response, const Vector6& preload,
                                       common::Progress& progress) {
  if (interfaces.size() != 2 || interfaces[0].coupling != Coupling::rigid ||
      interfaces[1].coupling != Coupling::rigid)
    throw std::invalid_argument("geometric_stiffness: two rigid interfaces are required");
  const ReferenceBody body{interfaces[1].point, interfaces[1].geometry.nodes};
  const Matrix6 compliance = response.compliance();
  const Matrix6 stiffness =
      spatial::Compliance6(0.5 * (compliance + compliance.transpose())).inverse().matrix();
  const std::vector<Eigen::Matrix3Xd> motions = unit_motions(response, stiffness);

  GeometricStiffness result{.per_load = {},
                            .stiffness = stiffness,
                            .buckling_free = std::numeric_limits<double>::infinity(),
                            .buckling_held = std::numeric_limits<double>::infinity()};
  for (std::size_t j = 0; j < 6; ++j) {
    progress.report(phase, static_cast<double>(j) / 6);
    result.per_load[j] =
        projected(mesh, body, Prestress(mesh, materials, response.fields[j]), motions);
    result.stiffness += preload[static_cast<Eigen::Index>(j)] * result.per_load[j];
  }
  if (preload.isZero(0)) return result;

  const Prestress prestress(mesh, materials, combined(response.fields, preload));
  {
    const StressedModel free(mesh, materials, DofMap(mesh, interfaces[0].geometry.nodes, {body}),
                             prestress, progress);
    result.buckling_free = buckling_factor(free, progress);
  }
  const StressedModel held(mesh, materials, with_both_held(mesh, interfaces), prestress, progress);
  result.buckling_held = buckling_factor(held, progress);
  if (result.buckling_held <= 1) throw BeyondBuckling(result.buckling_held);
  result.stiffness += relaxation(held, prestress, motions, progress);
  return result;
}

}  // namespace kinetostat::fea
