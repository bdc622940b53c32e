#include "kinetostat/vjm/exchange/robot_import.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/chain/particles.h"

namespace kinetostat::vjm::robot_import {
namespace {

using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;

// Rounding of products of poses is not written as a figure.
double rounded(double value, double negligible = 1e-15) {
  return std::abs(value) < negligible ? 0.0 : value;
}

std::string vector_text(const Vector3& v) {
  return fmt::format("[{:.15g}, {:.15g}, {:.15g}]", rounded(v.x()), rounded(v.y()), rounded(v.z()));
}

std::string pose_text(const Pose& pose) {
  const Vector3 turn = spatial::log_rotation(pose.rotation());
  if (turn.norm() < 1e-14) return vector_text(pose.position());
  return fmt::format("{{point: {}, rotation_vector: {}}}", vector_text(pose.position()),
                     vector_text(turn));
}

// A frame in which the joint's axis is +x, +y or +z: turned only when it is along none of them.
struct JointFrame {
  Matrix3 rotation = Matrix3::Identity();
  char letter = 'z';
};

JointFrame frame_of(const Vector3& axis) {
  for (int i = 0; i < 3; ++i)
    if ((axis - Vector3::Unit(i)).norm() < 1e-12)
      return {Matrix3::Identity(), static_cast<char>('x' + i)};
  // z along the axis; x is any direction across it.
  const Vector3 across = axis.cross(std::abs(axis.x()) < 0.9 ? Vector3::UnitX() : Vector3::UnitY());
  const Matrix3 x_along = spatial::rotation_from_axes(axis, across);
  Matrix3 z_along;
  z_along << x_along.col(1), x_along.col(2), x_along.col(0);
  return {z_along, 'z'};
}

// Mass, its moment and its inertia about the origin of the start frame.
struct MassSum {
  double mass = 0;
  Vector3 moment = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
  bool has_tensor = false, is_assumed = false;

  static Matrix3 steiner(double mass, const Vector3& arm) {
    return mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  void add(const DescribedInertia& part, const Pose& place) {
    const Vector3 center = place * part.center;
    mass += part.mass;
    moment += part.mass * center;
    inertia +=
        place.rotation() * part.tensor * place.rotation().transpose() + steiner(part.mass, center);
    has_tensor = has_tensor || !part.tensor.isZero(0);
    is_assumed = is_assumed || part.is_assumed;
  }
};

std::string lines_with_indent(const std::string& lines, const std::string& indent) {
  std::string out;
  for (std::size_t at = 0, end; (end = lines.find('\n', at)) != std::string::npos; at = end + 1)
    out += indent + lines.substr(at, end + 1 - at);
  return out;
}

class Importer {
 public:
  Importer(const RobotDescription& model, const DescribedChain& chain, const ImportOptions& options)
      : model_(model), chain_(chain), options_(options) {}

  ImportedRobot run() {
    body_.name = chain_.base;
    add_link(chain_.base, false);
    for (const std::size_t number : chain_.joints) {
      const DescribedJoint& joint = model_.joints[number];
      place_ = place_ * joint.origin;
      if (joint.type == JointType::fixed) {
        add_link(joint.child, moving_);
        continue;
      }
      add_joint(joint);
      add_link(joint.child, true);
    }
    if (!moving_)
      throw common::InputError(model_.file, fmt::format("no joint moves between '{}' and '{}'",
                                                        chain_.base, chain_.tip));
    finish_body(Pose(), std::nullopt);
    result_.text = text();
    return result_;
  }

 private:
  // What is fixed to the base carries nothing.
  void add_link(const std::string& name, bool moves) {
    const auto link = std::find_if(model_.links.begin(), model_.links.end(),
                                   [&](const DescribedLink& l) { return l.name == name; });
    if (!moves) return;
    if (is_between(body_.name) && !is_between(name)) body_.name = name;
    for (DescribedShape shape : link->shapes) {
      shape.pose = place_ * shape.pose;
      body_.shapes.push_back(std::move(shape));
    }
    if (link->inertia) masses_.add(*link->inertia, place_);
    add_branches(name, place_, true);
  }

  // What is fixed to a link beside the chain is carried along; what moves there is left out.
  void add_branches(const std::string& parent, const Pose& place, bool is_fixed,
                    std::size_t depth = 0) {
    if (depth > model_.joints.size()) return;  // a loop
    for (std::size_t number = 0; number < model_.joints.size(); ++number) {
      const DescribedJoint& joint = model_.joints[number];
      if (joint.parent != parent || is_in_chain(number)) continue;
      const bool carried = is_fixed && joint.type == JointType::fixed;
      const Pose behind = place * joint.origin;
      for (const DescribedLink& link : model_.links) {
        if (link.name != joint.child || !link.inertia || !(link.inertia->mass > 0)) continue;
        if (carried)
          masses_.add(*link.inertia, behind);
        else
          result_.left_out.push_back({link.name, link.inertia->mass});
      }
      add_branches(joint.child, behind, carried, depth + 1);
    }
  }

  bool is_in_chain(std::size_t joint) const {
    return std::find(chain_.joints.begin(), chain_.joints.end(), joint) != chain_.joints.end();
  }

  // A frame that a reader has put before a link: "child@joint".
  static bool is_between(const std::string& name) { return name.find('@') != std::string::npos; }

  void add_joint(const DescribedJoint& joint) {
    const JointFrame frame = frame_of(joint.axis);
    const Pose turned = Pose::rotation(frame.rotation);
    finish_body(turned, (place_ * turned).rotation().col(frame.letter - 'x'));
    const std::string axis = std::string(turns(joint) ? "R" : "T") + frame.letter;
    const Followed followed = followed_by(joint);
    const auto driven = driven_.find(followed.leader->name);
    if (followed.factor == 0) {
      add_offset(axis, followed.offset, turns(joint));  // it stands where the offset has it
    } else if (driven == driven_.end()) {
      add_actuator(in_place_of_leader(joint, followed), axis);
      if (followed.leader != &joint)
        elements_ += fmt::format("      # in place of {}, which it follows by {:.6g}\n",
                                 common::printable(followed.leader->name), followed.factor);
      driven_[followed.leader->name] = {&joint, followed.factor, followed.offset};
    } else {
      add_mimic(joint, axis, followed, driven->second);
    }
    // From here on places are taken in the joint's turned frame.
    place_ = turned.inverse();
    body_ = {.name = joint.child, .start_axis = Vector3::Unit(frame.letter - 'x')};
    masses_ = {};
    moving_ = true;
  }

  void add_actuator(const DescribedJoint& joint, const std::string& axis) {
    double home = 0;
    std::string range;
    if (joint.limits) {
      const auto [lower, upper] = *joint.limits;
      if (lower > 0 || upper < 0) home = 0.5 * (lower + upper);
      if (lower < upper) range = fmt::format(", range: [{}, {}]", lower, upper);
    }
    if (joint.rest && !is_out_of_range(joint, *joint.rest)) home = *joint.rest;
    const std::string name = io::yaml_scalar(joint.name);
    const char* unit = turns(joint) ? "N m/rad" : "N/m";
    const auto given = options_.stiffness.find(joint.name);
    const std::optional<double> stiffness =
        given != options_.stiffness.end() ? std::optional(given->second) : joint.stiffness;
    const std::string spring =
        stiffness ? fmt::format(", stiffness: {:.15g} {}", *stiffness, unit) : "";
    elements_ += fmt::format("    - actuator: {{name: {}, axis: {}{}{}{}}}\n", name, axis,
                             home == 0 ? "" : fmt::format(", home: {}", home), range, spring);
    result_.drives.push_back(joint);
    if (!spring.empty()) return;
    elements_ +=
        fmt::format("      # MISSING: 'stiffness: ... {}' of drive and transmission\n", unit);
    result_.missing.push_back(
        {fmt::format("actuator {}", joint.name),
         fmt::format("stiffness of drive and transmission [{}]; rigid until it is given", unit)});
  }

  [[noreturn]] void refuse_mimic(const DescribedJoint& joint, const std::string& what) const {
    throw common::InputError(
        {.file = model_.file,
         .line = joint.line,
         .key = joint.name,
         .what = what,
         .cure = "Correct the joint that it names, or write the robot file by hand"});
  }

  // The joint that the last of those that were passed mimics, which must be none of them.
  const DescribedJoint& mimicked(const std::vector<const DescribedJoint*>& passed) const {
    const DescribedJoint& last = *passed.back();
    const auto next = std::find_if(model_.joints.begin(), model_.joints.end(),
                                   [&](const DescribedJoint& j) { return j.name == last.mimics; });
    if (next == model_.joints.end())
      refuse_mimic(last, fmt::format("it mimics '{}', and there is no such joint", last.mimics));
    const auto first = std::find(passed.begin(), passed.end(), &*next);
    if (first == passed.end()) return *next;
    if (&**first == &last) refuse_mimic(last, "it mimics itself");
    std::vector<std::string> names;
    for (auto at = first; at != passed.end(); ++at)
      names.push_back(fmt::format("'{}'", (*at)->name));
    refuse_mimic(**first, fmt::format("joints mimic each other in a circle, so that none leads: {} "
                                      "and '{}' again",
                                      fmt::join(names, ", "), next->name));
  }

  // q = factor * q_leader + offset of the joint that leads all, itself where it mimics none.
  struct Followed {
    const DescribedJoint* leader = nullptr;
    double factor = 1, offset = 0;
  };
  Followed followed_by(const DescribedJoint& joint) const {
    Followed result{.leader = &joint};
    std::vector<const DescribedJoint*> passed;
    while (!result.leader->mimics.empty()) {
      const DescribedJoint& now = *result.leader;
      passed.push_back(&now);
      result.leader = &mimicked(passed);
      result.offset += result.factor * now.mimic_offset;
      result.factor *= now.mimic_factor;
    }
    if (result.leader->type == JointType::fixed) result.factor = 0;
    return result;
  }

  // The joint of the chain that is driven for a leader: itself, or, where that is on a side branch
  // or comes later, the first that follows it.
  struct Driven {
    const DescribedJoint* joint = nullptr;
    double factor = 1, offset = 0;
  };

  // Side by side with its own one.
  static void add_spring_of_leader(const DescribedJoint& leader, const Followed& followed,
                                   DescribedJoint& joint) {
    const double own = joint.stiffness.value_or(0),
                 other = *leader.stiffness / (followed.factor * followed.factor),
                 there = followed.factor * leader.rest.value_or(0) + followed.offset;
    joint.stiffness = own + other;
    joint.rest = (own * joint.rest.value_or(0) + other * there) / (own + other);
  }

  // A joint that is driven for another one has what that has, counted in its own motion: the spring
  // beside its own, what both limits leave, the effort.
  DescribedJoint in_place_of_leader(DescribedJoint joint, const Followed& followed) const {
    const DescribedJoint& leader = *followed.leader;
    if (leader.name == joint.name) return joint;
    if (leader.stiffness) add_spring_of_leader(leader, followed, joint);
    if (leader.effort) joint.effort = *leader.effort / std::abs(followed.factor);
    if (leader.limits) {
      double lower = followed.factor * leader.limits->front() + followed.offset;
      double upper = followed.factor * leader.limits->back() + followed.offset;
      if (lower > upper) std::swap(lower, upper);
      if (joint.limits) {
        lower = std::max(lower, joint.limits->front());
        upper = std::min(upper, joint.limits->back());
      }
      if (lower < upper) joint.limits = {lower, upper};
    }
    return joint;
  }

  void add_offset(const std::string& axis, double offset, bool is_turn) {
    if (offset == 0) return;
    const Vector3 along = offset * Vector3::Unit(axis[1] - 'x');
    const Pose shift =
        is_turn ? Pose::rotation(spatial::exp_rotation(along)) : Pose::translation(along);
    elements_ += fmt::format("    - offset: {}\n", pose_text(shift));
  }

  void add_mimic(const DescribedJoint& joint, const std::string& axis, const Followed& followed,
                 const Driven& driven) {
    const double factor = followed.factor / driven.factor;
    add_offset(axis, followed.offset - factor * driven.offset, turns(joint));
    const char* unit = turns(*driven.joint) == turns(joint) ? ""
                       : turns(*driven.joint)               ? " m/rad"
                                                            : " rad/m";
    elements_ += fmt::format("    - coupled: {{to: {}, axis: {}, factor: {}{}}}   # {}\n",
                             io::yaml_scalar(driven.joint->name), axis, factor, unit,
                             common::printable(joint.name));
  }

  // Ends the body before the next joint, whose frame is `turned` in that of the described joint and
  // whose axis, if there is one, is `axis` in the start frame.
  void finish_body(const Pose& turned, const std::optional<Vector3>& axis) {
    body_.end = place_ * turned;
    if (!moving_) {
      base_ = body_.end;
      return;
    }
    body_.end_axis = axis;
    body_.mass = masses_.mass;
    const std::string name = io::yaml_scalar(body_.name);
    for (const DescribedShape& shape : body_.shapes)
      if (!shape.file.empty())
        links_ +=
            common::printable(fmt::format("  # mesh of {}: {}", body_.name, shape.file)) + "\n";
    const auto given = options_.links.find(body_.name);
    if (given != options_.links.end()) {
      links_ += fmt::format("  {}:\n{}", name, lines_with_indent(given->second, "    "));
    } else {
      links_ += fmt::format("  {}:   # MISSING: its compliance, rigid until then\n", name);
      links_ += fmt::format("    rigid: {}\n", pose_text(body_.end));
      say_missing();
    }
    add_mass();
    elements_ += fmt::format("    - link: {}\n", name);
    result_.bodies.push_back(body_);
  }

  void say_missing() {
    const auto reason = options_.reasons.find(body_.name);
    result_.missing.push_back(
        {fmt::format("links.{}", body_.name),
         reason != options_.reasons.end() ? "compliance: rigid, for " + reason->second
         : body_.shapes.empty() || body_.shapes.front().file.empty()
             ? "compliance: a beam or a link file of 'kinetostat identify'"
             : fmt::format("compliance: 'kinetostat identify' on {}", body_.shapes.front().file)});
  }

  void add_mass() {
    if (!(masses_.mass > 0)) {
      if (masses_.has_tensor)
        links_ += "    # its inertia is left out: the file gives it no mass\n";
      return;
    }
    const Vector3 center = masses_.moment / masses_.mass;
    const Matrix3 i = masses_.inertia - MassSum::steiner(masses_.mass, center);
    const bool possible = is_possible_inertia(i);
    if (masses_.has_tensor && !possible)
      links_ += "    # its inertia is left out: no body can have what the file says\n";
    if (masses_.is_assumed)
      links_ +=
          fmt::format("    # 1 kg and 1 kg m^2 of it are what {} means where a link says nothing\n",
                      model_.format);
    const double none = 1e-15 * i.norm();
    const std::string inertia =
        masses_.has_tensor && possible
            ? fmt::format(", inertia: [{:.15g}, {:.15g}, {:.15g}, {:.15g}, {:.15g}, {:.15g}]",
                          i(0, 0), rounded(i(0, 1), none), rounded(i(0, 2), none), i(1, 1),
                          rounded(i(1, 2), none), i(2, 2))
            : "";
    links_ += fmt::format("    mass: {{mass: {:.15g} kg, center: {}{}}}\n", masses_.mass,
                          vector_text(center), inertia);
  }

  std::string notes() const {
    std::string lines;
    for (const std::string& note : options_.notes) lines += "# " + common::printable(note) + "\n";
    for (const std::string& remark : model_.remarks)
      lines += "# " + common::printable(remark) + "\n";
    if (!result_.left_out.empty())
      lines += "# " + common::printable(in_words(result_.left_out)) + "\n";
    return lines;
  }

  // With all joints at zero.
  Matrix3 base_in_root() const {
    Matrix3 rotation = Matrix3::Identity();
    const DescribedJoint* joint = carrier_of(model_, chain_.base);
    for (std::size_t steps = 0; joint != nullptr && steps < model_.joints.size(); ++steps) {
      rotation = joint->origin.rotation() * rotation;
      joint = carrier_of(model_, joint->parent);
    }
    return rotation;
  }

  std::string gravity() const {
    const double g = model_.gravity.norm();
    if (!(g > 0)) return "";
    const std::string acceleration =
        std::abs(g - 9.80665) < 1e-12 ? "" : fmt::format(", acceleration: {:.15g} m/s^2", g);
    const bool is_usual = model_.gravity == RobotDescription().gravity;
    return fmt::format("gravity: {{direction: {}{}}}   # {}, axes of {}\n",
                       vector_text(base_in_root().transpose() * model_.gravity / g), acceleration,
                       is_usual ? "as usual" : fmt::format("as {} has it", model_.format),
                       common::printable(chain_.base));
  }

  std::string text() const {
    std::string out = fmt::format(
        "# Imported from {} ('{}' to '{}') by 'kinetostat import'.\n"
        "# What {} does not know and has to be added is marked MISSING.\n{}"
        "kinetostat: 1\n"
        "name: {}\n"
        "units: {{length: m, force: N, angle: rad}}\n{}\n",
        common::printable(model_.file.filename().string()), common::printable(chain_.base),
        common::printable(chain_.tip), model_.format, notes(), io::yaml_scalar(model_.name),
        gravity());
    out +=
        fmt::format("links:\n{}\nchain_types:\n  arm:\n{}\nmanipulator: {{chain: arm, base: {}}}\n",
                    links_, elements_, pose_text(base_));
    return out;
  }

  const RobotDescription& model_;
  const DescribedChain& chain_;
  const ImportOptions& options_;
  ImportedRobot result_;
  ImportedBody body_;
  MassSum masses_;
  bool moving_ = false;
  Pose place_;  // frame of the current described link, in the frame behind the last joint
  Pose base_;
  std::map<std::string, Driven> driven_;  // by leaders
  std::string links_, elements_;
};

}  // namespace
}  // namespace kinetostat::vjm::robot_import

namespace kinetostat::vjm {

std::string in_words(const std::vector<LeftOutLink>& left_out) {
  double mass = 0;
  std::vector<std::string> names;
  for (const LeftOutLink& link : left_out) {
    mass += link.mass;
    names.push_back("'" + link.name + "'");
  }
  return fmt::format("Left out, as it moves on a branch beside the chain: {} ({:.3g} kg).",
                     fmt::join(names, ", "), mass);
}

ImportedRobot import_robot(const RobotDescription& robot, const DescribedChain& chain,
                           const ImportOptions& options) {
  return robot_import::Importer(robot, chain, options).run();
}

}  // namespace kinetostat::vjm
