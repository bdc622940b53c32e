#include "kinetostat/vjm/manipulator/shared_mounts.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::vjm {

using spatial::Pose;
using spatial::Vector3;

namespace {

bool is_own(const Manipulator& manipulator, std::size_t chain) {
  return !manipulator.is_within_elastic_body(chain);
}

// Where its chains end, on average, in its axes.
Vector3 middle_of_platform(const Manipulator& manipulator) {
  Vector3 sum = Vector3::Zero();
  double count = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    if (manipulator.span(c).to != Span::platform || !is_own(manipulator, c)) continue;
    sum += manipulator.chains()[c].attachment().inverse().position();
    ++count;
  }
  return sum / count;
}

// From its place in the frame where it starts; it ends in that frame.
Chain rigid_chain(const std::vector<Chain>& others, std::string name, const Vector3& place) {
  const auto is_taken = [&](const Chain& other) { return other.name() == name; };
  while (std::any_of(others.begin(), others.end(), is_taken)) name += '_';
  return ChainBuilder(std::move(name), Pose::translation(place))
      .offset(Pose::translation(-place))
      .build();
}

// Chains and bodies as they become.
struct Mounted {
  std::vector<Chain> chains;
  std::vector<Span> spans;
  std::vector<std::string> inner_bodies;
  std::vector<ElasticBody> elastic_bodies;

  explicit Mounted(const Manipulator& without)
      : chains(without.chains()),
        inner_bodies(without.body_names().begin() + 1, without.body_names().end()),
        elastic_bodies(without.elastic_bodies()) {
    for (std::size_t c = 0; c < without.size(); ++c) spans.push_back(without.span(c));
  }

  // What is fastened to one body is fastened to a new one then.
  int exchange(int body, std::string name) {
    inner_bodies.push_back(std::move(name));
    const int added = static_cast<int>(inner_bodies.size());
    const auto take = [&](int& number) {
      if (number == body) number = added;
    };
    for (Span& span : spans) {
      take(span.from);
      take(span.to);
    }
    for (ElasticBody& elastic : elastic_bodies) {
      take(elastic.origin);
      for (ElasticBody::Interface& interface : elastic.interfaces) take(interface.body);
    }
    return added;
  }
};

bool several(const Manipulator& manipulator, int Span::*side, int body) {
  int count = 0;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    count += manipulator.span(c).*side == body && is_own(manipulator, c) ? 1 : 0;
  return count > 1;
}

}  // namespace

bool may_have_foundation(const Manipulator& manipulator) {
  return several(manipulator, &Span::from, Span::base);
}

bool may_have_tool(const Manipulator& manipulator) {
  return several(manipulator, &Span::to, Span::platform);
}

std::size_t SharedMounts::chain(std::size_t number, const Manipulator& without) const {
  if (number == tool) return without.size();
  if (number == foundation) return without.size() + (has_tool ? 1 : 0);
  return number;
}

Manipulator SharedMounts::on(const Manipulator& without) const {
  if (!any()) return without;
  Mounted made(without);
  if (has_tool) {
    const Vector3 middle = middle_of_platform(without);
    const int held = made.exchange(Span::platform, "platform without its tool");
    made.chains.push_back(rigid_chain(made.chains, "tool", middle));
    made.spans.push_back({held, Span::platform});
  }
  if (has_foundation) {
    const int stands = made.exchange(Span::base, "foundation");
    made.chains.push_back(rigid_chain(made.chains, "foundation", Vector3::Zero()));
    made.spans.push_back({Span::base, stands});
  }
  return Manipulator(without.name(), std::move(made.chains), std::move(made.spans),
                     std::move(made.inner_bodies))
      .with_elastic_bodies(std::move(made.elastic_bodies))
      .with_gravity(without.gravity());
}

Posture SharedMounts::on(const Posture& without, const Manipulator& with) const {
  Posture posture = without;
  if (has_tool) posture.inner_bodies.push_back(without.platform);
  if (has_foundation) posture.inner_bodies.emplace_back();
  for (std::size_t c = without.coordinates.size(); c < with.size(); ++c)
    posture.coordinates.emplace_back(Eigen::VectorXd::Zero(with.chains()[c].size()));
  return posture;
}

}  // namespace kinetostat::vjm
