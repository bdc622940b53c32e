#include "kinetostat/vjm/batches/relaxed_chain.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>

namespace kinetostat::vjm {
namespace {

using Eigen::Index;
using spatial::Pose;
using spatial::Vector3;
using spatial::Vector6;

// What a posture chooses; nothing when a spring joins several of it or others.
std::optional<std::vector<RelaxedChain::Chosen>> chosen_of(const Chain& chain) {
  std::vector<RelaxedChain::Chosen> chosen;
  for (const Index k : chain.posture_coordinates()) {
    const Coordinate& coordinate = chain.coordinates()[static_cast<std::size_t>(k)];
    const double stiffness = chain.stiffness()(k, k);
    if (chain.stiffness().col(k).squaredNorm() != stiffness * stiffness) return std::nullopt;
    chosen.push_back({.coordinate = k,
                      .compliance = stiffness == 0 ? 0 : 1 / stiffness,
                      .is_free = coordinate.role == Role::passive && stiffness == 0,
                      .turns = is_rotation(coordinate.motion)});
  }
  return chosen;
}

// Where a coordinate of a link stands: its twist at the origin of its segment, in its axes.
struct ElasticTwist {
  int joints = -1;  // that lead to the segment; -1: to none yet
  Vector6 twist = Vector6::Zero();
};

// Joints and tail into `result`, and the twists of the elastic coordinates; false when a coordinate
// is on several segments.
bool find_joints(const Chain& chain, RelaxedChain& result, std::vector<ElasticTwist>& elastic) {
  const std::vector<Index>& order = chain.posture_coordinates();
  Pose since;  // the joint before
  for (const Joint& joint : chain.joints()) {
    since = since * joint.before;
    const Vector3 axis = since.rotation().col(axis_index(joint.motion));
    const auto place = std::find(order.begin(), order.end(), joint.coordinate);
    if (place != order.end()) {
      result.joints.push_back({.rotation = since.rotation(),
                               .position = since.position(),
                               .motion = joint.motion,
                               .coordinate = static_cast<int>(place - order.begin()),
                               .factor = joint.factor});
      since = Pose();
      continue;
    }
    ElasticTwist& at = elastic[static_cast<std::size_t>(joint.coordinate)];
    const int segment = static_cast<int>(result.joints.size());
    if (at.joints >= 0 && at.joints != segment) return false;
    at.joints = segment;
    if (is_rotation(joint.motion))
      at.twist += joint.factor * (Vector6() << since.position().cross(axis), axis).finished();
    else
      at.twist.head<3>() += joint.factor * axis;
  }
  result.tail = since * chain.tail();
  return true;
}

// The springs of the links, segment by segment; false when one lies over several.
bool add_springs(const Chain& chain, const std::vector<ElasticTwist>& elastic,
                 RelaxedChain& result) {
  for (const Spring& spring : chain.springs()) {
    const Index n = spring.stiffness.rows();
    const auto of = [&](Index k) { return elastic[static_cast<std::size_t>(spring.first + k)]; };
    const auto role = chain.coordinates()[static_cast<std::size_t>(spring.first)].role;
    if (n == 1 && role != Role::elastic) continue;  // a drive's
    Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6> twists(6, n);
    for (Index k = 0; k < n; ++k) {
      if (of(k).joints < 0 || of(k).joints != of(0).joints) return false;
      twists.col(k) = of(k).twist;
    }
    if (result.segments.empty() || result.segments.back().joints != of(0).joints)
      result.segments.push_back({of(0).joints, spatial::Matrix6::Zero()});
    result.segments.back().compliance += twists * spring.stiffness.llt().solve(twists.transpose());
  }
  return true;
}

std::optional<RelaxedChain> relaxed(const Chain& chain) {
  RelaxedChain result;
  const auto chosen = chosen_of(chain);
  if (!chosen || chosen->empty() || chosen->size() > RelaxedChain::most_coordinates)
    return std::nullopt;
  result.chosen = *chosen;
  std::vector<ElasticTwist> elastic(chain.coordinates().size());
  if (!find_joints(chain, result, elastic) || !add_springs(chain, elastic, result) ||
      result.joints.size() > RelaxedChain::most_joints)
    return std::nullopt;
  return result;
}

}  // namespace

std::vector<RelaxedChain> relaxed_chains(const std::vector<Chain>& chains) {
  std::vector<RelaxedChain> result;
  for (const Chain& chain : chains) {
    std::optional<RelaxedChain> one = relaxed(chain);
    if (!one) return {};
    result.push_back(*std::move(one));
  }
  return result;
}

}  // namespace kinetostat::vjm
