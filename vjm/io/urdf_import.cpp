// From a URDF chain to the text of a robot file.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/printable.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/io/urdf.h"

namespace kinetostat::vjm {
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

// All links that move together, as one link of the robot file.
struct Body {
  std::string name;
  Pose end = {};  // frame before the next joint, in the frame behind the last
  double mass = 0;
  Vector3 moment = Vector3::Zero();  // mass times centre
  std::vector<std::string> meshes = {}, comments = {};
};

class Importer {
 public:
  Importer(const UrdfModel& model, const UrdfChain& chain, const std::vector<double>& stiffness)
      : model_(model), chain_(chain), stiffness_(stiffness) {}

  ImportedRobot run() {
    body_.name = chain_.base;
    add_link(chain_.base, false);
    for (const std::size_t number : chain_.joints) {
      const UrdfJoint& joint = model_.joints[number];
      place_ = place_ * joint.origin;
      if (joint.type == UrdfJointType::fixed) {
        add_link(joint.child, moving_);
        continue;
      }
      add_joint(joint);
      add_link(joint.child, true);
    }
    if (!moving_)
      throw common::InputError(model_.file, fmt::format("no joint moves between '{}' and '{}'",
                                                        chain_.base, chain_.tip));
    finish_body(Pose());
    result_.text = text();
    return result_;
  }

 private:
  // What is fixed to the base carries nothing.
  void add_link(const std::string& name, bool moves) {
    const auto link = std::find_if(model_.links.begin(), model_.links.end(),
                                   [&](const UrdfLink& l) { return l.name == name; });
    if (!moves) return;
    body_.meshes.insert(body_.meshes.end(), link->meshes.begin(), link->meshes.end());
    if (!link->inertia) return;
    const UrdfInertia& inertia = *link->inertia;
    body_.mass += inertia.mass;
    body_.moment += inertia.mass * (place_ * inertia.center);
    if (inertia.moments == std::array<double, 6>{}) return;
    body_.comments.push_back(
        fmt::format("inertia of {} about its centre, ixx ixy ixz iyy iyz izz [kg m^2]: {} (statics "
                    "does not need it)",
                    name, fmt::join(inertia.moments, " ")));
  }

  void add_joint(const UrdfJoint& joint) {
    const JointFrame frame = frame_of(joint.axis);
    const Pose turned = Pose::rotation(frame.rotation);
    finish_body(turned);
    const std::string axis = std::string(turns(joint) ? "R" : "T") + frame.letter;
    const Followed followed = followed_by(joint);
    const auto driven = driven_.find(followed.leader);
    if (followed.factor == 0) {
      add_offset(axis, followed.offset, turns(joint));  // it stands where the offset has it
    } else if (driven == driven_.end()) {
      add_actuator(joint, axis);
      driven_[followed.leader] = {&joint, followed.factor, followed.offset};
    } else {
      add_mimic(joint, axis, followed, driven->second);
    }
    // From here on places are taken in the joint's turned frame.
    place_ = turned.inverse();
    body_ = {.name = joint.child};
    moving_ = true;
  }

  void add_actuator(const UrdfJoint& joint, const std::string& axis) {
    double home = 0;
    std::string range;
    if (joint.limits) {
      const auto [lower, upper] = *joint.limits;
      if (lower > 0 || upper < 0) home = 0.5 * (lower + upper);
      if (lower < upper) range = fmt::format(", range: [{:.6g}, {:.6g}]", lower, upper);
    }
    const std::string name = io::yaml_scalar(joint.name);
    const char* unit = turns(joint) ? "N m/rad" : "N/m";
    const std::size_t drive = result_.drives.size();
    const std::string spring = drive < stiffness_.size()
                                   ? fmt::format(", stiffness: {:.15g} {}", stiffness_[drive], unit)
                                   : "";
    elements_ += fmt::format("    - actuator: {{name: {}, axis: {}{}{}{}}}\n", name, axis,
                             home == 0 ? "" : fmt::format(", home: {:.6g}", home), range, spring);
    result_.drives.push_back(joint);
    if (!spring.empty()) return;
    elements_ +=
        fmt::format("      # MISSING: 'stiffness: ... {}' of drive and transmission\n", unit);
    result_.missing.push_back(
        {fmt::format("actuator {}", joint.name),
         fmt::format("stiffness of drive and transmission [{}]; rigid until it is given", unit)});
  }

  // q = factor * q_leader + offset of the joint that leads all, itself where it mimics none.
  struct Followed {
    std::string leader;
    double factor = 1, offset = 0;
  };
  Followed followed_by(const UrdfJoint& joint) const {
    Followed result{.leader = joint.name};
    const UrdfJoint* now = &joint;
    for (std::size_t steps = 0; !now->mimics.empty(); ++steps) {
      const auto next = std::find_if(model_.joints.begin(), model_.joints.end(),
                                     [&](const UrdfJoint& j) { return j.name == now->mimics; });
      if (next == model_.joints.end() || steps > model_.joints.size())
        throw common::InputError(
            {.file = model_.file,
             .line = now->line,
             .key = now->name,
             .what = fmt::format("it mimics '{}', {}", now->mimics,
                                 next == model_.joints.end() ? "and there is no such joint"
                                                             : "which mimics it in turn"),
             .cure = "Correct the joint that it names, or write the robot file by hand"});
      result.offset += result.factor * now->mimic_offset;
      result.factor *= now->mimic_factor;
      result.leader = next->name;
      now = &*next;
    }
    return result;
  }

  // The joint of the chain that is driven for a leader: itself, or, where that is on a side branch
  // or comes later, the first that follows it.
  struct Driven {
    const UrdfJoint* joint = nullptr;
    double factor = 1, offset = 0;
  };

  void add_offset(const std::string& axis, double offset, bool is_turn) {
    if (offset == 0) return;
    const Vector3 along = offset * Vector3::Unit(axis[1] - 'x');
    const Pose shift =
        is_turn ? Pose::rotation(spatial::exp_rotation(along)) : Pose::translation(along);
    elements_ += fmt::format("    - offset: {}\n", pose_text(shift));
  }

  void add_mimic(const UrdfJoint& joint, const std::string& axis, const Followed& followed,
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

  // Ends the body before the next joint, whose frame is `turned` in that of the URDF joint.
  void finish_body(const Pose& turned) {
    const Pose end = place_ * turned;
    if (!moving_) {
      base_ = end;
      return;
    }
    const std::string name = io::yaml_scalar(body_.name);
    for (const std::string& mesh : body_.meshes)
      links_ += common::printable(fmt::format("  # mesh of {}: {}", body_.name, mesh)) + "\n";
    for (const std::string& comment : body_.comments)
      links_ += common::printable("  # " + comment) + "\n";
    links_ += fmt::format("  {}:   # MISSING: its compliance, rigid until then\n", name);
    links_ += fmt::format("    rigid: {}\n", pose_text(end));
    if (body_.mass > 0)
      links_ += fmt::format("    mass: {{mass: {:.15g} kg, center: {}}}\n", body_.mass,
                            vector_text(body_.moment / body_.mass));
    elements_ += fmt::format("    - link: {}\n", name);
    result_.missing.push_back(
        {fmt::format("links.{}", body_.name),
         body_.meshes.empty()
             ? "compliance: a beam or a link file of 'kinetostat identify'"
             : fmt::format("compliance: 'kinetostat identify' on {}", body_.meshes.front())});
  }

  std::string text() const {
    std::string out = fmt::format(
        "# Imported from {} ('{}' to '{}') by 'kinetostat import'.\n"
        "# URDF knows no stiffness: what has to be added is marked MISSING.\n"
        "kinetostat: 1\n"
        "name: {}\n"
        "units: {{length: m, force: N, angle: rad}}\n"
        "gravity: {{direction: [0, 0, -1]}}   # URDF's convention: z of the root is up\n\n",
        common::printable(model_.file.filename().string()), common::printable(chain_.base),
        common::printable(chain_.tip), io::yaml_scalar(model_.name));
    out +=
        fmt::format("links:\n{}\nchain_types:\n  arm:\n{}\nmanipulator: {{chain: arm, base: {}}}\n",
                    links_, elements_, pose_text(base_));
    return out;
  }

  const UrdfModel& model_;
  const UrdfChain& chain_;
  const std::vector<double>& stiffness_;
  ImportedRobot result_;
  Body body_;
  bool moving_ = false;
  Pose place_;  // frame of the current URDF link, in the frame behind the last joint
  Pose base_;
  std::map<std::string, Driven> driven_;  // by leaders
  std::string links_, elements_;
};

}  // namespace

bool turns(const UrdfJoint& joint) { return joint.type != UrdfJointType::prismatic; }

ImportedRobot import_robot(const UrdfModel& model, const UrdfChain& chain,
                           const std::vector<double>& stiffness) {
  return Importer(model, chain, stiffness).run();
}

}  // namespace kinetostat::vjm
