#include "kinetostat/vjm/io/mjcf_export.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/vjm/chain/particles.h"

namespace kinetostat::vjm::mjcf_export {
namespace {

using Eigen::Index;
using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;

// Of the inertia, so that there is some about every axis; and the least that a body has.
constexpr double little = 1e-9;

// What moves together: from one joint to the next.
struct Body {
  Index joint = -1;  // number of the elementary joint that moves it; -1: the ground
  Index from = 0;    // it has the frames behind `from` joints and more
  Pose frame;        // in the base, all coordinates as in the posture
  double mass = 0;
  Vector3 center = Vector3::Zero();   // in its frame
  Matrix3 inertia = Matrix3::Zero();  // about the centre, its axes
};

class Writer {
 public:
  Writer(const Robot& robot, const Posture& posture)
      : robot_(robot),
        chain_(robot.manipulator.chains().front()),
        x_(posture.coordinates_of(chain_, 0)),
        rest_(posture.rest(chain_, 0)) {
    evaluate(chain_, x_, kinematics_);
    find_bodies();
    add_masses();
  }

  MjcfExport run() && {
    add("<mujoco model=\"{}\">\n", escaped(robot_.name));
    add("  <compiler angle=\"radian\" autolimits=\"true\"/>\n");
    const Vector3 g = robot_.manipulator.gravity();
    add("  <option gravity=\"{}\"/>\n  <worldbody>\n", words(g));
    for (std::size_t b = 1; b < bodies_.size(); ++b) open_body(b);
    add_tool();
    for (std::size_t b = bodies_.size(); b-- > 1;) add("{}</body>\n", std::string(2 * b + 2, ' '));
    add("  </worldbody>\n  <keyframe>\n    <key name=\"posture\" qpos=\"");
    for (std::size_t b = 1; b < bodies_.size(); ++b)
      add("{}{}", b == 1 ? "" : " ", displacement(chain_joint(bodies_[b])));
    add("\"/>\n  </keyframe>\n</mujoco>\n");
    say_what_is_lost();
    return std::move(out_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(out_.text), format, std::forward<Arguments>(arguments)...);
  }

  static std::string words(const Vector3& v) {
    // Without the sign of a zero.
    return fmt::format("{} {} {}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
  }

  static std::string escaped(const std::string& text) {
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

  const Joint& chain_joint(const Body& body) const {
    return chain_.joints()[static_cast<std::size_t>(body.joint)];
  }
  const Coordinate& coordinate(const Joint& joint) const {
    return chain_.coordinates()[static_cast<std::size_t>(joint.coordinate)];
  }
  bool has_spring(Index coordinate) const { return chain_.stiffness()(coordinate, coordinate) > 0; }
  // A link's spring and a drive that holds its command do not move here.
  bool moves(const Joint& joint) const {
    const Role role = coordinate(joint).role;
    return role == Role::passive || (role == Role::actuated && has_spring(joint.coordinate));
  }
  double displacement(const Joint& joint) const { return joint.factor * x_[joint.coordinate]; }

  void find_bodies() {
    std::set<Index> moving;
    bodies_.emplace_back();
    for (Index j = 0; j < std::ssize(chain_.joints()); ++j) {
      const Joint& joint = chain_.joints()[static_cast<std::size_t>(j)];
      if (!moves(joint)) continue;
      if (!moving.insert(joint.coordinate).second)
        throw std::invalid_argument(
            fmt::format("joints that share the coordinate '{}' cannot be written for MuJoCo",
                        coordinate(joint).name));
      bodies_.push_back({.joint = j, .from = j + 1, .frame = frame_behind(chain_, x_, j + 1)});
    }
  }

  Body& body_behind(Index joints) {
    const auto next = std::find_if(bodies_.begin(), bodies_.end(),
                                   [joints](const Body& b) { return b.from > joints; });
    return *std::prev(next);
  }

  void add_masses() {
    const std::vector<Particle> particles = particles_of(chain_, x_, kinematics_);
    for (const Particle& particle : particles) {
      Body& body = body_behind(particle.joints);
      body.mass += particle.mass;
      body.center += particle.mass * (body.frame.inverse() * particle.position);
    }
    for (Body& body : bodies_)
      if (body.mass > 0) body.center /= body.mass;
    for (const Particle& particle : particles) {
      Body& body = body_behind(particle.joints);
      const Vector3 arm = body.frame.inverse() * particle.position - body.center;
      body.inertia +=
          particle.mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose()) +
          body.frame.rotation().transpose() * particle.inertia * body.frame.rotation();
    }
  }

  // The frame of a body where its joint stands at zero, in that of the body before.
  Pose origin(std::size_t b) const {
    const Joint& joint = chain_joint(bodies_[b]);
    Eigen::VectorXd x = x_;
    x[joint.coordinate] = 0;
    return bodies_[b - 1].frame.inverse() * frame_behind(chain_, x, bodies_[b].from);
  }

  void open_body(std::size_t b) {
    const Body& body = bodies_[b];
    const Joint& joint = chain_joint(body);
    const std::string indent(2 * b + 2, ' ');
    const std::string name = escaped(coordinate(joint).name);
    const Pose pose = origin(b);
    add("{}<body name=\"{}\" {}>\n", indent, name, place(pose));
    const Matrix3 inertia =
        body.inertia + std::max(little * body.inertia.trace(), little) * Matrix3::Identity();
    add("{}  <inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>\n", indent,
        words(body.center), std::max(body.mass, little), inertia(0, 0), inertia(1, 1),
        inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2));
    add("{}  <joint name=\"{}\" type=\"{}\" axis=\"{}\"{}/>\n", indent, name,
        is_rotation(joint.motion) ? "hinge" : "slide",
        words(Vector3::Unit(axis_index(joint.motion))), spring(joint));
  }

  static std::string place(const Pose& pose) {
    const Eigen::Quaterniond q(pose.rotation());
    return fmt::format("pos=\"{}\" quat=\"{} {} {} {}\"", words(pose.position()), q.w() + 0.0,
                       q.x() + 0.0, q.y() + 0.0, q.z() + 0.0);
  }

  // A coordinate that a factor multiplies has a spring of 1 / factor^2 of the joint.
  std::string spring(const Joint& joint) const {
    if (!has_spring(joint.coordinate)) return {};
    const double stiffness = chain_.stiffness()(joint.coordinate, joint.coordinate);
    return fmt::format(" stiffness=\"{}\" springref=\"{}\"",
                       stiffness / (joint.factor * joint.factor),
                       joint.factor * rest_[joint.coordinate]);
  }

  void add_tool() {
    const Pose tool = bodies_.back().frame.inverse() * kinematics_.end;
    add("{}<site name=\"tool\" {}/>\n", std::string(2 * bodies_.size() + 2, ' '), place(tool));
  }

  void say_what_is_lost() {
    std::set<std::string> links;
    for (const Spring& spring : chain_.springs())
      if (chain_.coordinates()[static_cast<std::size_t>(spring.first)].role == Role::elastic)
        links.insert(spring.name);
    for (const std::string& link : links)
      out_.lost.push_back(fmt::format("link {} is rigid: there are no springs of six directions",
                                      common::printable(link)));
    for (const Effect& effect : robot_.effects)
      out_.lost.push_back(
          fmt::format("effect {}: its law, as far as it is more than a linear "
                      "spring, a mass or a shifted frame",
                      effect.kind->name));
    out_.lost.emplace_back("damping and friction: the robot file has none");
  }

  const Robot& robot_;
  const Chain& chain_;
  Eigen::VectorXd x_, rest_;
  ChainKinematics kinematics_;
  std::vector<Body> bodies_;
  MjcfExport out_;
};

}  // namespace
}  // namespace kinetostat::vjm::mjcf_export

namespace kinetostat::vjm {

MjcfExport mjcf(const Robot& robot, const Posture& posture) {
  const Manipulator& manipulator = robot.manipulator;
  if (manipulator.size() != 1 || !manipulator.is_parallel())
    throw std::invalid_argument("only a robot of one chain can be written for MuJoCo");
  return mjcf_export::Writer(robot, posture).run();
}

}  // namespace kinetostat::vjm
