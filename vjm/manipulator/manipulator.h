// Manipulators: rigid bodies joined by chains, from serial arms to cross-linked mechanisms.
#pragma once

#include <string>
#include <vector>

#include "kinetostat/vjm/chain/chain.h"
#include "kinetostat/vjm/manipulator/elastic_body.h"

namespace kinetostat::vjm {

/// The bodies that a chain joins, by number; the base does not move.
struct Span {
  static constexpr int base = -1;
  static constexpr int platform = 0;

  int from = base;
  int to = platform;
};

/// Constant description. Body 0 is the platform, whose frame origin is the reference point (tool
/// point) of the manipulator; further bodies are inner ones (the crosspiece of a parallelogram). A
/// chain runs from the frame of its first body to the frame of its last: one that ends elsewhere on
/// a body is extended by a rigid link (IROS11 section IV), so that stiffness and wrenches simply
/// add. An elastic body is a group of chains between the bodies that its interfaces move with.
class Manipulator {
 public:
  /// All chains run from the base to the platform: a serial arm, or a parallel robot. Throws
  /// std::invalid_argument without chains, or with two of the same name.
  Manipulator(std::string name, const std::vector<Chain>& chains);
  /// Chains between any bodies; `inner_bodies` names bodies 1, 2, ... Throws std::invalid_argument
  /// also when a span is out of range or a body hangs on no chain.
  Manipulator(std::string name, std::vector<Chain> chains, std::vector<Span> spans,
              std::vector<std::string> inner_bodies);

  const std::string& name() const { return name_; }
  const std::vector<Chain>& chains() const { return chains_; }
  std::size_t size() const { return chains_.size(); }
  const Span& span(std::size_t chain) const { return spans_[chain]; }
  std::size_t body_count() const { return body_names_.size(); }
  const std::vector<std::string>& body_names() const { return body_names_; }  // "platform", ...
  /// Every chain runs from base to platform, by itself.
  bool is_parallel() const { return body_count() == 1 && elastic_bodies_.empty(); }

  const std::vector<ElasticBody>& elastic_bodies() const { return elastic_bodies_; }
  /// With these. Throws std::invalid_argument when a chain of one is not six coordinates without
  /// springs, or a matrix has another size than those.
  Manipulator with_elastic_bodies(std::vector<ElasticBody> bodies) const;
  /// Whether a chain is the way from one interface of an elastic body to another.
  bool is_within_elastic_body(std::size_t chain) const;

  /// Acceleration of gravity [m/s^2], base axes; it acts on the masses of the chains.
  const spatial::Vector3& gravity() const { return gravity_; }
  Manipulator with_gravity(const spatial::Vector3& gravity) const;
  /// The same manipulator with its reference point elsewhere on the platform (in platform axes).
  Manipulator with_reference_point(const spatial::Vector3& point_on_platform) const;
  /// The same manipulator with one chain exchanged.
  Manipulator with_chain(std::size_t index, Chain chain) const;
  /// With as many chains exchanged as it has: between the same bodies.
  Manipulator with_chains(std::vector<Chain> chains) const { return {*this, std::move(chains)}; }
  /// Whether gravity pulls at anything.
  bool has_weight() const;
  /// Whether a posture is an equilibrium by itself: no weight, no geometric errors, no passive
  /// springs or stops that could press.
  bool is_relaxed_when_unloaded() const;
  bool has_errors() const;
  /// The nominal manipulator, without geometric errors of its chains.
  Manipulator without_errors() const;

 private:
  Manipulator(const Manipulator& like, std::vector<Chain> chains)
      : name_(like.name_),
        chains_(std::move(chains)),
        spans_(like.spans_),
        body_names_(like.body_names_),
        elastic_bodies_(like.elastic_bodies_),
        gravity_(like.gravity_) {}

  std::string name_;
  std::vector<Chain> chains_;
  std::vector<Span> spans_;
  std::vector<std::string> body_names_;
  std::vector<ElasticBody> elastic_bodies_;
  spatial::Vector3 gravity_ = spatial::Vector3::Zero();
};

/// Where a manipulator stands with all springs relaxed: coordinates of every chain (the values of
/// actuated joints are their commands), all of which agree on the poses of the bodies.
struct Posture {
  spatial::Pose platform;                        // in base axes
  std::vector<Eigen::VectorXd> coordinates;      // one per chain; 0 for virtual springs
  std::vector<spatial::Pose> inner_bodies = {};  // bodies 1, 2, ... in base axes

  /// The coordinates of a chain. Springs that effects have appended to it stand at 0.
  Eigen::VectorXd coordinates_of(const Chain& chain, std::size_t index) const;
  /// Commands of the actuated joints of a chain, given rest values of its passive springs.
  Eigen::VectorXd commands(const Chain& chain, std::size_t index) const;
  /// Rest values of its springs: the commands, or where drives lead the joints instead.
  Eigen::VectorXd rest(const Chain& chain, std::size_t index) const;
  /// Pose of a body, Span::base included.
  spatial::Pose body(int number) const;
};

}  // namespace kinetostat::vjm
