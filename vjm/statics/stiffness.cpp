#include "kinetostat/vjm/statics/stiffness.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/vjm/chain/relaxed_stiffness.h"
#include "kinetostat/vjm/statics/newton_matrix.h"

namespace kinetostat::vjm {
namespace {

using Eigen::MatrixXd;
using spatial::Matrix6;
using spatial::Stiffness6;
using spatial::Vector6;

constexpr double dependent = 1e-10;  // of the largest of some columns is left of the last

double length_of(const ChainKinematics& kinematics) {
  return kinematics.reach > 0 ? kinematics.reach : 1.0;
}

// Six rows in place: chain after chain and pose after pose asks for no memory.
constexpr int most_columns = 12;
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, most_columns>;
using Basis = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

// A chain with how stiff its coordinates are: its springs alone, or with what laws of joints add.
struct SprungChain {
  const Chain& chain;
  const MatrixXd& stiffness;

  // A perfect passive joint, or a spring that a law takes away.
  bool is_free(Eigen::Index k) const {
    return stiffness(k, k) == 0 &&
           (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::passive ||
            chain.stiffness()(k, k) != 0);
  }
  // A law without a spring beside it.
  bool is_law_alone(Eigen::Index k) const {
    return stiffness(k, k) != 0 && chain.stiffness()(k, k) == 0;
  }
};

// Twists that free joints allow, rotations scaled to lengths, or a basis of them.
Columns passive_jacobian(const SprungChain& sprung, const ChainKinematics& kinematics,
                         const Vector6& scale) {
  Columns passive(6, 0);
  for (Eigen::Index k = 0; k < sprung.chain.size(); ++k) {
    if (!sprung.is_free(k)) continue;
    const Vector6 column = scale.cwiseProduct(kinematics.jacobian.col(k));
    // A unit column keeps the rank decision independent of how far away the joint is.
    const double norm = column.norm();
    if (!(norm > 0)) continue;
    if (passive.cols() == most_columns) passive = spatial::range_of(passive, dependent);
    passive.conservativeResize(Eigen::NoChange, passive.cols() + 1);
    passive.rightCols<1>() = column / norm;
  }
  return passive;
}

// Orthonormal basis of the wrenches that do no work on the passive joints.
Basis transmitted_wrenches(const Columns& passive) {
  if (passive.cols() == 0) return Matrix6::Identity();
  Eigen::ColPivHouseholderQR<Columns> factors;
  factors.setThreshold(dependent);
  factors.compute(passive);
  const Matrix6 q = factors.householderQ() * Matrix6::Identity();
  return q.rightCols(6 - factors.rank());
}

// J K^-1 J' as R'R with R = L^-1 J' and K = L L'.
Matrix6 felt_through(const Matrix6& jacobian, const Matrix6& stiffness) {
  const Matrix6 root = stiffness.llt().matrixLLT();
  Matrix6 rows = jacobian.transpose();
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) rows.row(i) -= root(i, k) * rows.row(k);
    rows.row(i) /= root(i, i);
  }
  return rows.transpose().lazyProduct(rows);
}

// Compliance of the springs felt at the end, J_s K_s^-1 J_s'.
Matrix6 spring_compliance(const SprungChain& sprung, const ChainKinematics& kinematics,
                          const Vector6& scale) {
  Matrix6 compliance = Matrix6::Zero();
  const auto add_joint = [&](Eigen::Index k) {
    if (sprung.stiffness(k, k) == 0) return;
    const Vector6 column = scale.cwiseProduct(kinematics.jacobian.col(k));
    compliance.noalias() += column * (column / sprung.stiffness(k, k)).transpose();
  };
  for (const Spring& spring : sprung.chain.springs()) {
    const Eigen::Index n = spring.stiffness.rows();
    if (n == 1) {
      add_joint(spring.first);
      continue;
    }
    const Basis jacobian = scale.asDiagonal() * kinematics.jacobian.middleCols(spring.first, n);
    const auto stiffness = sprung.stiffness.block(spring.first, spring.first, n, n);
    if (n == 6)
      compliance += felt_through(jacobian, stiffness);
    else
      compliance += jacobian * stiffness.llt().solve(jacobian.transpose());
  }
  for (Eigen::Index k = 0; k < sprung.chain.size(); ++k)
    if (sprung.is_law_alone(k)) add_joint(k);
  return compliance;
}

// Stiffness and compliance of a manipulator with rigid chains, inner or elastic bodies, whose
// chains do not simply add up: through the whole system of equations.
void add_from_equations(const Manipulator& manipulator, const Posture& posture,
                        const spatial::Frame& frame, UnloadedStiffness& result) {
  const auto symmetric = [](const Matrix6& m) { return Matrix6(0.5 * (m + m.transpose())); };
  const EquilibriumSystem system(manipulator, posture);
  const EquilibriumResiduals relaxed(system, system.relaxed_state(), {.gravity = 0});
  if (!system.has_rigid_directions()) {
    const Matrix6 stiffness = system.is_chainwise()
                                  ? ChainwiseFactor(relaxed, false).platform_stiffness()
                                  : WholeFactor(relaxed, false).platform_stiffness();
    result.stiffness = Stiffness6(symmetric(stiffness), frame);
    result.free = free_motions(*result.stiffness, result.length);
    if (result.free.rank == 6) result.compliance = result.stiffness->inverse();
    return;
  }
  const WholeFactor factor(relaxed, false);
  const Matrix6 compliance = factor.platform_compliance().matrix;
  result.free = describe_twists(factor.tangent().motions_without_energy(), frame, result.length);
  if (result.free.rank < 6) return;
  result.compliance = spatial::Compliance6(symmetric(compliance), frame);
  result.rigid = rigid_wrenches(*result.compliance, result.length);
  if (result.rigid.rank == 6) result.stiffness = result.compliance->inverse();
}

std::optional<Stiffness6> unloaded_stiffness(const SprungChain& sprung,
                                             const ChainKinematics& kinematics) {
  const spatial::Frame frame{kinematics.end.position()};
  const Vector6 scale = Scale{.length = length_of(kinematics)}.twist();

  const Basis basis = transmitted_wrenches(passive_jacobian(sprung, kinematics, scale));
  if (basis.cols() == 0) return Stiffness6(Matrix6::Zero(), frame);

  const Matrix6 compliance = spring_compliance(sprung, kinematics, scale);
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  const Basis felt = compliance.lazyProduct(basis);
  const Small reduced = basis.transpose().lazyProduct(felt);
  const Eigen::LDLT<Small> factor(reduced);
  if (!(factor.vectorD().minCoeff() > 1e-13 * factor.vectorD().maxCoeff())) return std::nullopt;
  const Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6> wrenches = basis.transpose();
  const Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6> shared = factor.solve(wrenches);
  const Matrix6 scaled = basis.lazyProduct(shared);
  const Matrix6 matrix = scale.asDiagonal() * scaled * scale.asDiagonal();
  return Stiffness6(0.5 * (matrix + matrix.transpose()), frame);
}

// Laws of joints as they are in the posture.
std::optional<Stiffness6> relaxed_stiffness_of(const Manipulator& manipulator,
                                               const Posture& posture, std::size_t c,
                                               const ChainKinematics& kinematics) {
  const Chain& chain = manipulator.chains()[c];
  if (chain.laws().empty()) return unloaded_stiffness(chain, kinematics);
  const MatrixXd stiffness = relaxed_stiffness(chain, posture.coordinates_of(chain, c));
  return unloaded_stiffness(SprungChain{chain, stiffness}, kinematics);
}

}  // namespace

std::optional<Stiffness6> unloaded_stiffness(const Chain& chain,
                                             const ChainKinematics& kinematics) {
  return unloaded_stiffness(SprungChain{chain, chain.stiffness()}, kinematics);
}

std::optional<Stiffness6> unloaded_stiffness_matrix(const Manipulator& manipulator,
                                                    const Posture& posture) {
  if (manipulator.has_errors())
    return unloaded_stiffness_matrix(manipulator.without_errors(), posture);
  if (!manipulator.is_parallel()) return unloaded_stiffness(manipulator, posture).stiffness;
  ChainKinematics kinematics;
  Matrix6 sum = Matrix6::Zero();
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    evaluate(manipulator.chains()[c], posture.coordinates[c], kinematics);
    const auto chain = relaxed_stiffness_of(manipulator, posture, c, kinematics);
    if (!chain) return unloaded_stiffness(manipulator, posture).stiffness;
    sum += chain->matrix();
  }
  return Stiffness6(sum, {posture.platform.position()});
}

UnloadedStiffness unloaded_stiffness(const Manipulator& manipulator, const Posture& posture) {
  if (manipulator.has_errors()) return unloaded_stiffness(manipulator.without_errors(), posture);
  const spatial::Frame frame{posture.platform.position()};
  UnloadedStiffness result;
  ChainKinematics kinematics;
  Matrix6 sum = Matrix6::Zero();
  bool rigid = false;
  double reach = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    evaluate(manipulator.chains()[c], posture.coordinates[c], kinematics,
             posture.body(manipulator.span(c).from));
    reach = std::max(reach, kinematics.reach);
    result.per_chain.push_back(relaxed_stiffness_of(manipulator, posture, c, kinematics));
    rigid |= !result.per_chain.back();
    if (result.per_chain.back()) sum += result.per_chain.back()->matrix();
  }
  result.length = reach > 0 ? reach : 1.0;
  for (const auto& chain : result.per_chain)
    result.free_per_chain.push_back(chain ? free_motions(*chain, result.length) : FreeMotions{});
  if (rigid || !manipulator.is_parallel()) {
    add_from_equations(manipulator, posture, frame, result);
    return result;
  }
  result.stiffness = Stiffness6(sum, frame);
  result.free = free_motions(*result.stiffness, result.length);
  if (result.free.rank == 6) result.compliance = result.stiffness->inverse();
  return result;
}

}  // namespace kinetostat::vjm
