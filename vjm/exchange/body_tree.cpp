#include "kinetostat/vjm/exchange/body_tree.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/coordinate_law.h"
#include "kinetostat/vjm/chain/particles.h"

namespace kinetostat::vjm::body_tree_of {
namespace {

using Eigen::Index;
using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;

// A body of the tree, with its place in the chain.
struct Place {
  Index joint = -1;  // number of the elementary joint that moves it; -1: the ground
  Index from = 0;    // it has the frames behind `from` joints and more
  Pose frame;        // in the base, all coordinates as in the posture
};

Matrix3 steiner(double mass, const Vector3& arm) {
  return mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
}

class Builder {
 public:
  Builder(const Robot& robot, const Posture& posture, const TreeOptions& options)
      : robot_(robot),
        options_(options),
        chain_(robot.manipulator.chains().front()),
        x_(posture.coordinates_of(chain_, 0)),
        rest_(posture.rest(chain_, 0)) {
    evaluate(chain_, x_, kinematics_);
  }

  BodyTree run() && {
    tree_.name = robot_.name;
    tree_.gravity = robot_.manipulator.gravity();
    find_bodies();
    for (TreeBody& body : tree_.bodies)
      if (body.name == "world") body.name = free_name("world", tree_);
    for (TreeBody& body : tree_.bodies)
      if (body.coupling)
        body.name = free_name(tree_.bodies[body.coupling->leader].name + "_coupled", tree_);
    add_masses();
    if (options_.damping_ratio > 0) add_dampers();
    tree_.tool = places_.back().frame.inverse() * kinematics_.end;
    say_what_is_lost();
    return std::move(tree_);
  }

 private:
  const Coordinate& coordinate(const Joint& joint) const {
    return chain_.coordinates()[static_cast<std::size_t>(joint.coordinate)];
  }
  bool has_spring(Index coordinate) const { return chain_.stiffness()(coordinate, coordinate) > 0; }
  // A link's spring and a drive that holds its command do not move here.
  bool moves(const Joint& joint) const {
    const Role role = coordinate(joint).role;
    return role == Role::passive || (role == Role::actuated && has_spring(joint.coordinate));
  }

  void find_bodies() {
    std::map<Index, std::size_t> leaders;  // by coordinates
    places_.emplace_back();
    for (Index j = 0; j < std::ssize(chain_.joints()); ++j) {
      const Joint& joint = chain_.joints()[static_cast<std::size_t>(j)];
      if (!moves(joint)) continue;
      places_.push_back({.joint = j, .from = j + 1, .frame = frame_behind(chain_, x_, j + 1)});
      const auto [leader, leads] = leaders.emplace(joint.coordinate, tree_.bodies.size());
      tree_.bodies.push_back(leads ? body_of(joint) : following(joint, leader->second));
    }
  }

  TreeBody following(const Joint& joint, std::size_t leader) const {
    TreeBody body = body_of(joint);
    const auto& leading = chain_.joints()[static_cast<std::size_t>(places_[leader + 1].joint)];
    body.coupling = {.leader = leader, .factor = joint.factor / leading.factor};
    body.stiffness.reset();
    body.rest = 0;
    return body;
  }

  // The last place is that of the joint. A coordinate that a factor multiplies has a spring of
  // 1 / factor^2 of the joint.
  TreeBody body_of(const Joint& joint) const {
    const Pose& before = places_[places_.size() - 2].frame;
    TreeBody body{.name = coordinate(joint).name,
                  .turns = is_rotation(joint.motion),
                  .axis = axis_index(joint.motion),
                  .origin = before.inverse() * frame_behind(chain_, x_, places_.back().from - 1) *
                            joint.before,
                  .value = joint.factor * x_[joint.coordinate]};
    if (const auto& range = coordinate(joint).range) {
      const auto [one, other] =
          std::minmax({joint.factor * range->front(), joint.factor * range->back()});
      body.range = {one, other};
    }
    if (has_spring(joint.coordinate)) {
      body.stiffness =
          chain_.stiffness()(joint.coordinate, joint.coordinate) / (joint.factor * joint.factor);
      body.rest = joint.factor * rest_[joint.coordinate];
    }
    return body;
  }

  // Number of the body, -1 for the ground.
  Index body_behind(Index joints) const {
    const auto next = std::find_if(places_.begin(), places_.end(),
                                   [joints](const Place& b) { return b.from > joints; });
    return std::distance(places_.begin(), next) - 2;
  }

  void add_masses() {
    const std::vector<Particle> particles = particles_of(chain_, x_, kinematics_);
    for (const Particle& particle : particles) {
      const Index b = body_behind(particle.joints);
      if (b < 0) continue;
      TreeBody& body = tree_.bodies[static_cast<std::size_t>(b)];
      body.mass += particle.mass;
      body.center += particle.mass * (frame(b).inverse() * particle.position);
    }
    for (TreeBody& body : tree_.bodies)
      if (body.mass > 0) body.center /= body.mass;
    for (const Particle& particle : particles) {
      const Index b = body_behind(particle.joints);
      if (b < 0) continue;
      TreeBody& body = tree_.bodies[static_cast<std::size_t>(b)];
      const Matrix3& axes = frame(b).rotation();
      body.inertia += steiner(particle.mass, frame(b).inverse() * particle.position - body.center) +
                      axes.transpose() * particle.inertia * axes;
    }
  }
  const Pose& frame(Index body) const { return places_[static_cast<std::size_t>(body) + 1].frame; }

  // With the inertia that each joint moves, and those that follow it.
  void add_dampers() {
    for (std::size_t j = 0; j < tree_.bodies.size(); ++j) {
      TreeBody& body = tree_.bodies[j];
      if (!body.stiffness) continue;
      double moved = 0;
      for (std::size_t b = j; b < tree_.bodies.size(); ++b) moved += inertia_at(j, b);
      body.damping = 2 * options_.damping_ratio * std::sqrt(*body.stiffness * moved);
    }
  }

  // Twice the energy of a body where a joint moves by one a second.
  double inertia_at(std::size_t joint, std::size_t carried) const {
    const TreeBody& body = tree_.bodies[carried];
    const Pose& at = frame(static_cast<Index>(carried));
    Vector3 speed = Vector3::Zero(), turn = Vector3::Zero();
    for (std::size_t k = joint; k <= carried; ++k) {
      const TreeBody& moving = tree_.bodies[k];
      if (k != joint && !(moving.coupling && moving.coupling->leader == joint)) continue;
      const Pose& own = frame(static_cast<Index>(k));
      const Vector3 along =
          (k == joint ? 1 : moving.coupling->factor) * own.rotation().col(moving.axis);
      speed += moving.turns ? along.cross(at * body.center - own.position()) : along;
      if (moving.turns) turn += at.rotation().transpose() * along;
    }
    return body.mass * speed.squaredNorm() + turn.dot(body.inertia * turn);
  }

  // Springs of bearings and mounts that effects add are no links of the robot file.
  bool is_of_effect(const std::string& spring) const {
    const Chain& bare = robot_.without_effects().chains().front();
    return std::none_of(bare.springs().begin(), bare.springs().end(),
                        [&](const Spring& s) { return s.name == spring; });
  }

  void say_what_is_lost() {
    std::set<std::string> links, by_effects;
    for (const Spring& spring : chain_.springs()) {
      if (chain_.coordinates()[static_cast<std::size_t>(spring.first)].role != Role::elastic)
        continue;
      if (is_of_effect(spring.name))  // "mount at base.Tx"
        by_effects.insert(spring.name.substr(0, spring.name.rfind('.')));
      else
        links.insert(spring.name);
    }
    for (const std::string& link : links)
      tree_.lost.push_back(fmt::format("link {} is rigid: joints have no springs of six directions",
                                       common::printable(link)));
    for (const std::string& spring : by_effects)
      tree_.lost.push_back(fmt::format("the compliance of the {}", common::printable(spring)));
    for (std::size_t c = 0; c < chain_.coordinates().size(); ++c) {
      const Coordinate& coordinate = chain_.coordinates()[c];
      if (coordinate.role == Role::actuated && !has_spring(static_cast<Index>(c)))
        tree_.lost.push_back(
            fmt::format("joint {} is fixed at its command: its drive has no stiffness",
                        common::printable(coordinate.name)));
    }
    say_what_laws_are_lost();
    for (std::string& effect : lost_effects(robot_)) tree_.lost.push_back(std::move(effect));
    tree_.lost.emplace_back(
        options_.damping_ratio > 0
            ? "friction: the robot file has none; the damping is what was asked for"
            : "damping and friction: the robot file has none");
  }

  void say_what_laws_are_lost() {
    for (const auto& [coordinate, law] : robot_.without_effects().chains().front().laws()) {
      const std::string name =
          common::printable(chain_.coordinates()[static_cast<std::size_t>(coordinate)].name);
      tree_.lost.push_back(
          std::dynamic_pointer_cast<const StopLaw>(law)
              ? fmt::format("the stops of joint {}, contact springs beyond its free range", name)
              : fmt::format("how the stiffness of joint {} changes along its way", name));
    }
  }

  const Robot& robot_;
  const TreeOptions& options_;
  const Chain& chain_;
  Eigen::VectorXd x_, rest_;
  ChainKinematics kinematics_;
  std::vector<Place> places_;  // the ground, then one for each body
  BodyTree tree_;
};

}  // namespace
}  // namespace kinetostat::vjm::body_tree_of

namespace kinetostat::vjm {

BodyTree body_tree(const Robot& robot, const Posture& posture, const TreeOptions& options) {
  const Manipulator& manipulator = robot.manipulator;
  if (manipulator.size() != 1 || !manipulator.is_parallel())
    throw std::invalid_argument("only a robot of one chain is a tree of bodies");
  return body_tree_of::Builder(robot, posture, options).run();
}

namespace {
constexpr double least = 1e-9;       // kg m^2 where there is none, and of the inertia itself
constexpr double least_mass = 2e-6;  // kg: Gazebo takes a millionth for nothing

bool lacks_inertia(const TreeBody& body) {
  return body.mass < least_mass || !(body.inertia.determinant() > 0);
}
}  // namespace

TreeBody with_least_inertia(TreeBody body) {
  body.inertia +=
      least * (lacks_inertia(body) ? 1 : body.inertia.trace()) * spatial::Matrix3::Identity();
  body.mass = std::max(body.mass, least_mass);
  return body;
}

namespace {
bool is_linear_spring(const Effect& effect, const Manipulator& bare) {
  if (!effect.kind->acts_on_joint_alone || effect.kind->varies) return false;
  const Manipulator with = with_effects(bare, {effect});
  const auto laws = [](std::size_t sum, const Chain& chain) { return sum + chain.laws().size(); };
  const auto count = [&](const Manipulator& all) {
    return std::accumulate(all.chains().begin(), all.chains().end(), std::size_t{0}, laws);
  };
  return count(with) == count(bare) && with.has_errors() == bare.has_errors();
}
}  // namespace

std::vector<std::string> lost_effects(const Robot& robot) {
  std::vector<std::string> lost;
  for (const Effect& effect : robot.effects)
    if (!is_linear_spring(effect, robot.without_effects()))
      lost.push_back(
          fmt::format("effect {}: its law, as far as it is more than a linear spring, a mass or a "
                      "shifted frame",
                      effect.kind->name));
  return lost;
}

std::vector<std::string> lost_in_file(std::vector<std::string> own, const BodyTree& tree,
                                      bool has_least_inertia) {
  std::vector<std::string> light;
  for (const TreeBody& body : tree.bodies)
    if (lacks_inertia(body)) light.push_back(common::printable(body.name));
  if (has_least_inertia && !light.empty())
    own.push_back(
        fmt::format("that nothing has a mass, or an inertia about some axis, behind {}: it has "
                    "2e-6 kg and 1e-9 kg m^2 there, for programs that ask for some",
                    fmt::join(light, ", ")));
  own.insert(own.end(), tree.lost.begin(), tree.lost.end());
  return own;
}

std::string free_name(std::string wanted, const BodyTree& tree) {
  const auto is_taken = [&](const TreeBody& body) {
    const std::string name = common::printable(body.name);
    return name == wanted || name + "_link" == wanted;
  };
  while (std::any_of(tree.bodies.begin(), tree.bodies.end(), is_taken)) wanted += '_';
  return wanted;
}

std::string xml_escaped(const std::string& text) {
  std::string out;
  for (const char c : common::printable(text)) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string xml_words(const spatial::Vector3& v) {
  return fmt::format("{} {} {}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

spatial::Vector3 roll_pitch_yaw(const spatial::Matrix3& r) {
  // Near straight up and down roll and yaw turn about one axis: whatever the roll, the yaw is what
  // is left of the rotation without it.
  const double roll = std::hypot(r(2, 1), r(2, 2)) > 0 ? std::atan2(r(2, 1), r(2, 2)) : 0;
  const spatial::Matrix3 m = r * spatial::exp_rotation({-roll, 0, 0});
  return {roll, std::atan2(-m(2, 0), m(2, 2)), std::atan2(-m(0, 1), m(1, 1))};
}

std::string lost_comment(const std::vector<std::string>& lost, const std::string& start,
                         const std::string& end) {
  std::string text;
  for (std::string what : lost) {
    // A comment of XML ends at the first "--".
    if (!end.empty())
      for (std::size_t at = 0; (at = what.find("--", at)) != std::string::npos; ++at)
        what.insert(at + 1, 1, ' ');
    text += fmt::format("{}not in this file: {}{}\n", start, what, end);
  }
  return text;
}

}  // namespace kinetostat::vjm
