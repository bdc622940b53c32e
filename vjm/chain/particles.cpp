#include "kinetostat/vjm/chain/particles.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Eigenvalues>

namespace kinetostat::vjm {
namespace {

using spatial::Matrix3;
using spatial::Vector3;

constexpr double rounding = 1e-6;  // of inertia in files, beside the largest

bool ends_with(const std::string& text, const char* ending) {
  const std::string tail(ending);
  return text.size() > tail.size() &&
         text.compare(text.size() - tail.size(), tail.size(), tail) == 0;
}

// The two halves of a part of a link, as LinkModel::append_to names them.
bool are_halves(const Chain& chain, const PointMass& first, const PointMass& second) {
  return first.element == second.element && first.mass == second.mass &&
         ends_with(chain.nodes()[first.node].name, ".mass1") &&
         ends_with(chain.nodes()[second.node].name, ".mass2");
}

// The integral of (x x') dm of a body, from its inertia, and back.
Matrix3 spread_of(const Matrix3& inertia) {
  return 0.5 * inertia.trace() * Matrix3::Identity() - inertia;
}
Matrix3 inertia_of(const Matrix3& spread) { return spread.trace() * Matrix3::Identity() - spread; }

// The largest share f of `arm`, at most 1, for which two halves at +-f arm have no more than
// `spread`, per mass.
double share_within(const Matrix3& spread, const Vector3& arm) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> axes(spread);
  const double least = rounding * std::max(axes.eigenvalues()[2], 0.0);
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double along = axes.eigenvectors().col(i).dot(arm), has = axes.eigenvalues()[i];
    if (std::abs(along) <= rounding * arm.norm()) continue;
    if (has <= least) return 0;
    sum += along * along / has;
  }
  return sum > 1 ? 1 / std::sqrt(sum) : 1;
}

// Halves at the same distance before and behind their middle, with the inertia of their link.
void place_halves(Particle& first, Particle& second) {
  const double nearer = std::sqrt(3.0) / 2;  // L / sqrt(12) beside L / 3
  const Vector3 center = (first.position + second.position) / 2;
  Vector3 arm = nearer * (second.position - center);
  const Matrix3 inertia = first.inertia + second.inertia;
  if (!inertia.isZero(0)) {
    const Matrix3 spread = spread_of(inertia) / (first.mass + second.mass);
    arm *= share_within(spread, arm);
    first.inertia = second.inertia = first.mass * inertia_of(spread - arm * arm.transpose());
  }
  first.position = center - arm;
  second.position = center + arm;
}

}  // namespace

std::vector<Particle> particles_of(const Chain& chain, const Eigen::VectorXd& x,
                                   const ChainKinematics& kinematics, const spatial::Pose& origin) {
  std::vector<Particle> particles;
  for (const PointMass& mass : chain.masses()) {
    const Eigen::Index joints = chain.nodes()[mass.node].joints;
    particles.push_back({kinematics.nodes[mass.node], joints, mass.mass});
    if (mass.inertia.isZero(0)) continue;
    const Matrix3 axes = frame_behind(chain, x, joints, origin).rotation();
    particles.back().inertia = axes * mass.inertia * axes.transpose();
  }
  for (std::size_t k = 0; k + 1 < particles.size(); ++k)
    if (are_halves(chain, chain.masses()[k], chain.masses()[k + 1]))
      place_halves(particles[k], particles[k + 1]);
  return particles;
}

bool is_possible_inertia(const Matrix3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> spread(spread_of(inertia), Eigen::EigenvaluesOnly);
  return spread.eigenvalues()[0] >= -rounding * spread.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace kinetostat::vjm
