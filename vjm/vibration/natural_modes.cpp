#include "kinetostat/vjm/vibration/natural_modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kinetostat/common/error.h"
#include "kinetostat/spatial/decomposition.h"
#include "kinetostat/vjm/chain/particles.h"
#include "kinetostat/vjm/chain/relaxed_stiffness.h"
#include "kinetostat/vjm/statics/equilibrium_residuals.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"
#include "kinetostat/vjm/statics/equilibrium_tangent.h"
#include "kinetostat/vjm/vibration/mass_spectrum.h"

namespace kinetostat::vjm::vibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using spatial::Vector3;

constexpr double dependent = 1e-10;  // of the agreement of chains
constexpr double idle = 1e-13;       // neither mass nor stiffness, beside the largest
constexpr double least_share = 1e-6;

// Motion of a point [translation; rotation] that follows a body which moves by t at another.
spatial::Matrix6 carried(const Vector3& arm) {
  spatial::Matrix6 motion = spatial::Matrix6::Identity();
  motion.topRows<3>() = spatial::rigid_motion(arm);
  return motion;
}

// The equations in all coordinates of the chains, then the motions of the bodies; rotations are
// multiplied by a length.
class System {
 public:
  System(const Manipulator& manipulator, Posture posture)
      : manipulator_(manipulator), posture_(std::move(posture)), kinematics_(manipulator.size()) {
    for (std::size_t c = 0; c < manipulator.size(); ++c) {
      const Chain& chain = manipulator.chains()[c];
      evaluate(chain, posture_.coordinates_of(chain, c), kinematics_[c],
               posture_.body(manipulator.span(c).from));
      first_.push_back(size_);
      size_ += chain.size();
      length_ = std::max(length_, kinematics_[c].reach);
    }
    bodies_ = size_;
    size_ += 6 * static_cast<Index>(manipulator.body_count());
    if (!(length_ > 0)) length_ = 1;
  }

  // An orthonormal basis of the motions on which all chains agree.
  MatrixXd motions() const {
    std::vector<Index> moving;
    for (std::size_t c = 0; c < chains().size(); ++c)
      for (const Index k : chains()[c].free_coordinates()) moving.push_back(first_[c] + k);
    for (Index k = bodies_; k < size_; ++k) moving.push_back(k);
    const MatrixXd conditions = agreement()(Eigen::all, moving);
    const MatrixXd free = spatial::complement_of(conditions.transpose(), dependent);
    MatrixXd basis = MatrixXd::Zero(size_, free.cols());
    basis(moving, Eigen::all) = free;
    return scale().cwiseInverse().asDiagonal() * basis;
  }

  const Posture& posture() const { return posture_; }

  // Of relaxed springs, and of laws in joints at rest.
  MatrixXd stiffness() const {
    MatrixXd stiffness = MatrixXd::Zero(size_, size_);
    for (std::size_t c = 0; c < chains().size(); ++c) {
      const Chain& chain = chains()[c];
      stiffness.block(first_[c], first_[c], chain.size(), chain.size()) =
          relaxed_stiffness(chain, posture_.coordinates_of(chain, c));
    }
    for (const ElasticBody& body : manipulator_.elastic_bodies()) {
      const std::vector<Index> places = places_of(body);
      stiffness(places, places) += body.stiffness;
    }
    return stiffness;
  }

  // Second derivative of the energy at an equilibrium of the same chains in this posture.
  MatrixXd stiffness(const EquilibriumTangent& tangent) const {
    const EquilibriumSystem& equations = tangent.system();
    std::vector<Index> places;  // of its rows
    std::vector<double> scale;
    for (Index k = bodies_; k < size_; ++k) {
      places.push_back(k);
      scale.push_back(equations.scale().twist()[(k - bodies_) % 6]);
    }
    for (std::size_t c = 0; c < chains().size(); ++c)
      for (Index k = 0; k < equations.chains()[c].size(); ++k) {
        places.push_back(first_[c] + chains()[c].free_coordinates()[static_cast<std::size_t>(k)]);
        scale.push_back(equations.chains()[c].unit()[k]);
      }
    const Eigen::Map<const VectorXd> scales(scale.data(), std::ssize(scale));
    MatrixXd stiffness = MatrixXd::Zero(size_, size_);
    stiffness(places, places) = equations.scale().stiffness * scales.asDiagonal() *
                                tangent.energy_hessian(false).hessian * scales.asDiagonal();
    return stiffness;
  }

  MatrixXd mass() const {
    MatrixXd mass = MatrixXd::Zero(size_, size_);
    for (std::size_t c = 0; c < chains().size(); ++c)
      for (const Particle& particle :
           particles_of(chains()[c], posture_.coordinates_of(chains()[c], c), kinematics_[c],
                        posture_.body(manipulator_.span(c).from))) {
        const MatrixXd jacobian = jacobian_of(c, particle);
        mass += particle.mass * jacobian.topRows<3>().transpose() * jacobian.topRows<3>();
        if (!particle.inertia.isZero(0))
          mass +=
              jacobian.bottomRows<3>().transpose() * particle.inertia * jacobian.bottomRows<3>();
      }
    for (const ElasticBody& elastic : manipulator_.elastic_bodies()) {
      if (elastic.inertia.size() == 0) continue;
      const MatrixXd jacobian = jacobian_of(elastic);
      mass += jacobian.transpose() * elastic.inertia * jacobian;
    }
    return mass;
  }

  // The rows of the platform.
  MatrixXd platform_of(const MatrixXd& motions) const { return motions.middleRows<6>(bodies_); }

  // The largest of the platform's six components is positive.
  ManipulatorMode mode(double omega_squared, VectorXd motion) const {
    Index largest = 0;
    motion.segment<6>(bodies_).cwiseAbs().maxCoeff(&largest);
    if (motion[bodies_ + largest] < 0) motion = -motion;
    ManipulatorMode mode{.frequency = std::sqrt(omega_squared) / (2 * std::numbers::pi),
                         .platform = motion.segment<6>(bodies_)};
    for (std::size_t c = 0; c < chains().size(); ++c)
      mode.coordinates.emplace_back(motion.segment(first_[c], chains()[c].size()));
    mode.springs = shares_of(mode, motion);
    return mode;
  }

 private:
  const std::vector<Chain>& chains() const { return manipulator_.chains(); }

  // Of each spring in the energy of all of them.
  std::vector<SpringShare> shares_of(const ManipulatorMode& mode, const VectorXd& motion) const {
    std::vector<SpringShare> shares;
    for (std::size_t c = 0; c < chains().size(); ++c)
      for (const Spring& spring : chains()[c].springs()) {
        const VectorXd d = mode.coordinates[c].segment(spring.first, spring.stiffness.rows());
        shares.push_back({c, spring.name, d.dot(spring.stiffness * d)});
      }
    for (const ElasticBody& body : manipulator_.elastic_bodies()) {
      const VectorXd d = motion(places_of(body));
      shares.push_back({body.chains[0], body.name, d.dot(body.stiffness * d)});
    }
    double all = 0;
    for (const SpringShare& one : shares) all += one.share;
    for (SpringShare& one : shares) one.share /= all;
    std::erase_if(shares, [](const SpringShare& one) { return !(one.share > least_share); });
    std::stable_sort(shares.begin(), shares.end(),
                     [](const SpringShare& a, const SpringShare& b) { return a.share > b.share; });
    return shares;
  }

  // What a rotation is multiplied by, coordinate by coordinate; 1 for a translation.
  VectorXd scale() const {
    VectorXd scale = VectorXd::Ones(size_);
    for (std::size_t c = 0; c < chains().size(); ++c)
      for (Index k = 0; k < chains()[c].size(); ++k)
        if (is_rotation(chains()[c].coordinates()[static_cast<std::size_t>(k)].motion))
          scale[first_[c] + k] = length_;
    for (Index k = bodies_; k < size_; k += 6) scale.segment<3>(k + 3).setConstant(length_);
    return scale;
  }

  // Of the deflections of an elastic body.
  std::vector<Index> places_of(const ElasticBody& body) const {
    std::vector<Index> places;
    for (const std::size_t c : body.chains)
      for (Index k = 0; k < 6; ++k) places.push_back(first_[c] + k);
    return places;
  }

  // Of the velocities of its interfaces, in its axes, by those of all coordinates.
  MatrixXd jacobian_of(const ElasticBody& elastic) const {
    const spatial::Pose axes = posture_.body(elastic.origin) * elastic.frame;
    const spatial::Matrix3 turn = axes.rotation().transpose();
    MatrixXd jacobian = MatrixXd::Zero(elastic.inertia.rows(), size_);
    Index row = 0;
    for (const ElasticBody::Interface& interface : elastic.interfaces) {
      if (interface.body != Span::base) {
        const spatial::Matrix6 motion = carried(axes * interface.point - place(interface.body));
        jacobian.block<3, 6>(row, body(interface.body)) = turn * motion.topRows<3>();
        jacobian.block<3, 6>(row + 3, body(interface.body)) = turn * motion.bottomRows<3>();
      }
      row += 6;
    }
    return jacobian;
  }

  Index body(int number) const { return bodies_ + Index{6} * number; }
  Vector3 place(int number) const { return posture_.body(number).position(); }

  // The end of every chain moves as its last body; zero times the scaled motion.
  MatrixXd agreement() const {
    MatrixXd rows = MatrixXd::Zero(6 * static_cast<Index>(chains().size()), size_);
    for (std::size_t c = 0; c < chains().size(); ++c) {
      auto six = rows.middleRows<6>(6 * static_cast<Index>(c));
      const auto [from, to] = manipulator_.span(c);
      six.middleCols(first_[c], chains()[c].size()) = kinematics_[c].jacobian;
      if (from != Span::base)
        six.middleCols<6>(body(from)) = carried(kinematics_[c].end.position() - place(from));
      six.middleCols<6>(body(to)) -= spatial::Matrix6::Identity();
      six.bottomRows<3>() *= length_;
    }
    return rows * scale().cwiseInverse().asDiagonal();
  }

  // Of the velocity of a particle and its angular velocity by the velocities of all coordinates.
  MatrixXd jacobian_of(std::size_t c, const Particle& particle) const {
    MatrixXd jacobian = MatrixXd::Zero(6, size_);
    const Vector3 from_end = particle.position - kinematics_[c].end.position();
    for (Index j = 0; j < particle.joints; ++j) {
      const Joint& joint = chains()[c].joints()[static_cast<std::size_t>(j)];
      jacobian.col(first_[c] + joint.coordinate) +=
          carried(from_end) * kinematics_[c].joint_twists.col(j);
    }
    if (const int from = manipulator_.span(c).from; from != Span::base)
      jacobian.middleCols<6>(body(from)) = carried(particle.position - place(from));
    return jacobian;
  }

  const Manipulator& manipulator_;
  Posture posture_;
  std::vector<ChainKinematics> kinematics_;
  std::vector<Index> first_;  // coordinate of each chain
  Index bodies_ = 0, size_ = 0;
  double length_ = 0;
};

MatrixXd seen_by(const MatrixXd& matrix, const MatrixXd& motions) {
  const MatrixXd seen = motions.transpose() * matrix * motions;
  return 0.5 * (seen + seen.transpose());
}

// Without those that have neither mass nor stiffness.
MatrixXd motions_with_energy(const System& system, const MatrixXd& stiffness,
                             const MatrixXd& mass) {
  const MatrixXd motions = system.motions();
  const MatrixXd k = seen_by(stiffness, motions), m = seen_by(mass, motions);
  const double largest_k = k.norm(), largest_m = m.norm();
  const spatial::SymmetricEigen sum = spatial::symmetric_eigen(k / (largest_k > 0 ? largest_k : 1) +
                                                               m / (largest_m > 0 ? largest_m : 1));
  const Index none = (sum.values.array() <= idle).count();
  return motions * sum.vectors.rightCols(sum.values.size() - none);
}

// K and M of a system in motions that are independent.
struct Equations {
  System system;
  MatrixXd motions, stiffness, mass;

  Equations(System of, const MatrixXd& k) : system(std::move(of)) {
    const MatrixXd m = system.mass();
    motions = motions_with_energy(system, k, m);
    stiffness = seen_by(k, motions);
    mass = seen_by(m, motions);
  }
};

Equations at_rest(const Manipulator& manipulator, const Posture& posture) {
  System system(manipulator, posture);
  const MatrixXd stiffness = system.stiffness();
  return {std::move(system), stiffness};
}

Equations under_load(const Manipulator& manipulator, const Posture& posture, const Load& load) {
  const EquilibriumSystem equations(manipulator, posture);
  const FoundState found = state_under_load(equations, load, {});
  if (found.status != EquilibriumStatus::converged) throw common::NoConvergence(found.reason);
  const EquilibriumResiduals at(equations, found.state, load);
  const EquilibriumTangent tangent(at);
  if (!stability_of(energy_spectrum(tangent.energy_hessian(false))).stable())
    throw common::NoConvergence(
        "the equilibrium under this load is unstable: it has no natural frequencies");
  const std::vector<spatial::Pose>& bodies = found.state.bodies;
  System system(manipulator, {.platform = bodies.front(),
                              .coordinates = found.state.coordinates,
                              .inner_bodies = {bodies.begin() + 1, bodies.end()}});
  const MatrixXd stiffness = system.stiffness(tangent);
  return {std::move(system), stiffness};
}

NaturalModes modes_of(const Equations& equations, double mass, int count) {
  NaturalModes result;
  result.mass = mass;
  result.posture = equations.system.posture();
  if (!(equations.mass.norm() > 0)) return result;
  const MassSpectrum spectrum(equations.stiffness, equations.mass);
  for (Index i = spectrum.size(); i-- > 0;) {
    if (!spectrum.has_mass(i) || std::ssize(result.modes) == count) break;
    if (spectrum.is_free(i)) {
      ++result.free_motions;
      continue;
    }
    const VectorXd y = spectrum.vector(i) / std::sqrt(spectrum.theta(i));
    result.modes.push_back(equations.system.mode(spectrum.omega_squared(i), equations.motions * y));
  }
  return result;
}

SmallMotions small_motions_of(const Equations& equations) {
  return {equations.stiffness, equations.mass, equations.system.platform_of(equations.motions)};
}

}  // namespace
}  // namespace kinetostat::vjm::vibration

namespace kinetostat::vjm {

double mass_of(const Manipulator& manipulator) {
  double mass = 0;
  for (const Chain& chain : manipulator.chains())
    for (const PointMass& point : chain.masses()) mass += point.mass;
  for (const ElasticBody& body : manipulator.elastic_bodies()) mass += body.mass;
  return mass;
}

NaturalModes natural_modes(const Manipulator& manipulator, const Posture& posture, int count) {
  if (manipulator.has_errors()) return natural_modes(manipulator.without_errors(), posture, count);
  return vibration::modes_of(vibration::at_rest(manipulator, posture), mass_of(manipulator), count);
}

NaturalModes natural_modes(const Manipulator& manipulator, const Posture& posture, const Load& load,
                           int count) {
  return vibration::modes_of(vibration::under_load(manipulator, posture, load),
                             mass_of(manipulator), count);
}

SmallMotions small_motions(const Manipulator& manipulator, const Posture& posture) {
  if (manipulator.has_errors()) return small_motions(manipulator.without_errors(), posture);
  return vibration::small_motions_of(vibration::at_rest(manipulator, posture));
}

SmallMotions small_motions(const Manipulator& manipulator, const Posture& posture,
                           const Load& load) {
  return vibration::small_motions_of(vibration::under_load(manipulator, posture, load));
}

}  // namespace kinetostat::vjm
