#include "kinetostat/vjm/manipulator/manipulator.h"

#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_builder.h"

namespace kinetostat::vjm {

Manipulator::Manipulator(std::string name, const std::vector<Chain>& chains)
    : Manipulator(std::move(name), chains, std::vector<Span>(chains.size()), {}) {}

Manipulator::Manipulator(std::string name, std::vector<Chain> chains, std::vector<Span> spans,
                         std::vector<std::string> inner_bodies)
    : name_(std::move(name)), chains_(std::move(chains)), spans_(std::move(spans)) {
  if (chains_.empty()) throw std::invalid_argument("a manipulator needs at least one chain");
  std::set<std::string> names;
  for (const Chain& chain : chains_)
    if (!names.insert(chain.name()).second)
      throw std::invalid_argument(fmt::format("two chains are named '{}'", chain.name()));
  body_names_.push_back("platform");
  for (std::string& body : inner_bodies) body_names_.push_back(std::move(body));
  if (spans_.size() != chains_.size())
    throw std::invalid_argument("every chain needs the two bodies that it joins");
  std::set<int> reached;
  const int bodies = static_cast<int>(body_names_.size());
  for (const Span& span : spans_) {
    if (span.from < Span::base || span.to < 0 || span.from >= bodies || span.to >= bodies ||
        span.from == span.to)
      throw std::invalid_argument("a chain must join two different bodies of the manipulator");
    reached.insert(span.to);
  }
  for (int body = 0; body < bodies; ++body)
    if (!reached.contains(body))
      throw std::invalid_argument(fmt::format("no chain ends on the body '{}'",
                                              body_names_[static_cast<std::size_t>(body)]));
}

Manipulator Manipulator::with_gravity(const spatial::Vector3& gravity) const {
  Manipulator copy = *this;
  copy.gravity_ = gravity;
  return copy;
}

Manipulator Manipulator::with_reference_point(const spatial::Vector3& point_on_platform) const {
  Manipulator copy = *this;
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    if (spans_[c].to == Span::platform)
      copy.chains_[c] =
          ChainBuilder(chains_[c]).attach(spatial::Pose::translation(point_on_platform)).build();
    if (spans_[c].from == Span::platform)
      throw std::invalid_argument("the reference point cannot move while a chain starts on it");
  }
  return copy;
}

Manipulator Manipulator::with_chain(std::size_t index, Chain chain) const {
  Manipulator copy = *this;
  copy.chains_.at(index) = std::move(chain);
  return copy;
}

Manipulator Manipulator::with_elastic_bodies(std::vector<ElasticBody> bodies) const {
  for (const ElasticBody& body : bodies) {
    const auto size = static_cast<Eigen::Index>(6 * body.chains.size());
    if (body.stiffness.rows() != size || body.stiffness.cols() != size ||
        body.interfaces.size() < 2 || (body.mass > 0 && body.moment.cols() != size))
      throw std::invalid_argument(fmt::format("the matrices of '{}' have another size", body.name));
    for (const std::size_t c : body.chains)
      if (chains_.at(c).size() != 6 || !chains_[c].springs().empty())
        throw std::invalid_argument(fmt::format(
            "the chain '{}' within an elastic body is not one elastic joint", chains_[c].name()));
  }
  Manipulator copy = *this;
  copy.elastic_bodies_ = std::move(bodies);
  return copy;
}

bool Manipulator::is_within_elastic_body(std::size_t chain) const {
  for (const ElasticBody& body : elastic_bodies_)
    for (const std::size_t c : body.chains)
      if (c == chain) return true;
  return false;
}

bool Manipulator::has_weight() const {
  return std::any_of(elastic_bodies_.begin(), elastic_bodies_.end(),
                     [&](const ElasticBody& body) { return body.has_weight(gravity_); }) ||
         (!gravity_.isZero(0) &&
          std::any_of(chains_.begin(), chains_.end(),
                      [](const Chain& chain) { return !chain.masses().empty(); }));
}

bool Manipulator::is_relaxed_when_unloaded() const {
  if (has_weight()) return false;
  for (const Chain& chain : chains_) {
    if (chain.has_errors() || !chain.laws().empty() || !chain.transmission_errors().empty())
      return false;
    for (const Spring& spring : chain.springs())
      if (chain.coordinates()[static_cast<std::size_t>(spring.first)].role == Role::passive)
        return false;
  }
  return true;
}

bool Manipulator::has_errors() const {
  for (const Chain& chain : chains_)
    if (chain.has_errors()) return true;
  return false;
}

Manipulator Manipulator::without_errors() const {
  Manipulator copy = *this;
  for (Chain& chain : copy.chains_) chain = chain.without_errors();
  return copy;
}

Eigen::VectorXd Posture::coordinates_of(const Chain& chain, std::size_t index) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(chain.size());
  x.head(coordinates[index].size()) = coordinates[index];
  return x;
}

Eigen::VectorXd Posture::commands(const Chain& chain, std::size_t index) const {
  Eigen::VectorXd commands = chain.default_rest();
  for (Eigen::Index k = 0; k < coordinates[index].size(); ++k)
    if (chain.coordinates()[static_cast<std::size_t>(k)].role == Role::actuated)
      commands[k] = coordinates[index][k];
  return commands;
}

Eigen::VectorXd Posture::rest(const Chain& chain, std::size_t index) const {
  return chain.rest_for(commands(chain, index));
}

spatial::Pose Posture::body(int number) const {
  if (number == Span::base) return {};
  if (number == Span::platform) return platform;
  return inner_bodies.at(static_cast<std::size_t>(number - 1));
}

}  // namespace kinetostat::vjm
