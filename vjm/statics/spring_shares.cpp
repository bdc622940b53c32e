#include "kinetostat/vjm/statics/spring_shares.h"

#include <algorithm>

#include "kinetostat/vjm/statics/equilibrium.h"
#include "kinetostat/vjm/statics/equilibrium_state.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::vjm {
namespace {

constexpr double small = 1e-6;        // deflection over the reach of the robot
constexpr double least_share = 1e-6;  // less is rounding

// A force under which the platform yields by that much; 0 where it does not yield.
double small_force(const UnloadedStiffness& unloaded, const spatial::Vector3& direction) {
  if (!unloaded.compliance) return 0;
  const double compliance =
      direction.dot(unloaded.compliance->matrix().topLeftCorner<3, 3>() * direction);
  return compliance > 0 ? small * unloaded.length / compliance : 0;
}

}  // namespace

std::string name_of(const Manipulator& manipulator, const SpringShare& share) {
  if (manipulator.is_within_elastic_body(share.chain)) return share.spring;
  return manipulator.chains()[share.chain].name() + "." + share.spring;
}

std::vector<SpringShare> spring_shares(const Manipulator& manipulator, const Posture& posture,
                                       const spatial::Vector3& direction) {
  const double force = small_force(unloaded_stiffness(manipulator, posture), direction);
  if (!(force > 0)) return {};
  Load load;
  const Equilibrium before = equilibrium_under_load(manipulator, posture, load);
  load.force = force * direction;
  const Equilibrium after = equilibrium_under_load(manipulator, posture, load);
  if (before.status != EquilibriumStatus::converged || after.status != EquilibriumStatus::converged)
    return {};
  std::vector<SpringShare> shares;
  double sum = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const Eigen::VectorXd moved = after.chains[c].coordinates - before.chains[c].coordinates;
    for (const Spring& spring : manipulator.chains()[c].springs()) {
      const Eigen::VectorXd d = moved.segment(spring.first, spring.stiffness.rows());
      shares.push_back({c, spring.name, d.dot(spring.stiffness * d)});
      sum += shares.back().share;
    }
  }
  const SystemState deflected = state_of(after), relaxed = state_of(before);
  for (const ElasticBody& body : manipulator.elastic_bodies()) {
    const Eigen::VectorXd d = EquilibriumSystem::deflections(body, deflected) -
                              EquilibriumSystem::deflections(body, relaxed);
    shares.push_back({body.chains[0], body.name, d.dot(body.stiffness * d)});
    sum += shares.back().share;
  }
  if (!(sum > 0)) return {};
  for (SpringShare& share : shares) share.share /= sum;
  std::erase_if(shares, [](const SpringShare& s) { return s.share < least_share; });
  std::stable_sort(shares.begin(), shares.end(),
                   [](const SpringShare& a, const SpringShare& b) { return a.share > b.share; });
  return shares;
}

}  // namespace kinetostat::vjm
