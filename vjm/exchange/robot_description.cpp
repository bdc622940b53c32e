#include "kinetostat/vjm/exchange/robot_description.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"

namespace kinetostat::vjm {

bool PrimitiveSolid::has_volume() const {
  if (kind == Kind::box) return edges.minCoeff() > 0;
  return radius > 0 && (kind == Kind::capsule ? length >= 0 : length > 0);
}

std::string DescribedShape::name() const {
  if (!file.empty()) return std::filesystem::path(file).filename().string();
  switch (solid.kind) {
    case PrimitiveSolid::Kind::box:
      return "a box";
    case PrimitiveSolid::Kind::cylinder:
      return "a cylinder";
    case PrimitiveSolid::Kind::capsule:
      break;
  }
  return solid.length > 0 ? "a capsule" : "a ball";
}

namespace {

std::vector<std::string> link_names(const RobotDescription& robot) {
  std::vector<std::string> names;
  for (const DescribedLink& link : robot.links) names.push_back(link.name);
  return names;
}

void require_link(const RobotDescription& robot, const std::string& link) {
  const std::vector<std::string> names = link_names(robot);
  if (std::find(names.begin(), names.end(), link) != names.end()) return;
  const std::string near = common::nearest_spelling(link, names);
  throw common::InputError(robot.file, fmt::format("there is no link '{}'", link),
                           near.empty() ? fmt::format("Links are {}", fmt::join(names, ", "))
                                        : fmt::format("Did you mean '{}'?", near));
}

std::string only_one(const RobotDescription& robot, const std::vector<std::string>& found,
                     const char* what, const char* option) {
  if (found.size() == 1) return found[0];
  throw common::InputError(
      robot.file,
      found.empty() ? fmt::format("there is no {}: the joints form a loop", what)
                    : fmt::format("there are several {}s: {}", what, fmt::join(found, ", ")),
      fmt::format("Name one with {}", option));
}

// Links that carry no other; frames without anything count where nothing else ends the chain.
std::vector<std::string> ends_of(const RobotDescription& robot) {
  const auto carries = [&robot](const std::string& link) {
    return std::any_of(robot.joints.begin(), robot.joints.end(), [&](const DescribedJoint& joint) {
      const auto child =
          std::find_if(robot.links.begin(), robot.links.end(),
                       [&joint](const DescribedLink& other) { return other.name == joint.child; });
      return joint.parent == link && !child->is_mark;
    });
  };
  std::vector<std::string> ends;
  for (const DescribedLink& link : robot.links)
    if (!link.is_mark && !carries(link.name)) ends.push_back(link.name);
  return ends;
}

// A frame on a link by one of the names that tools have: of exports of this program, of industrial
// robots in ROS and of MuJoCo's collection of robots.
std::optional<std::string> tool_on(const RobotDescription& robot, const std::string& link) {
  for (const char* name : {"tool", "tool_", "tool0", "tcp", "attachment_site"})
    for (const DescribedLink& mark : robot.links)
      if (const DescribedJoint* joint = carrier_of(robot, mark.name);
          mark.is_mark && mark.name == name && joint != nullptr && joint->parent == link)
        return mark.name;
  return std::nullopt;
}

// The only link that carries no other, or what industrial robots in ROS call the frame of the tool.
std::string usual_tip(const RobotDescription& robot) {
  const std::vector<std::string> ends = ends_of(robot);
  if (std::find(ends.begin(), ends.end(), "tool0") != ends.end()) return "tool0";
  const std::string last = only_one(robot, ends, "last link", "--tip");
  return tool_on(robot, last).value_or(last);
}

}  // namespace

const DescribedJoint* carrier_of(const RobotDescription& robot, const std::string& link) {
  for (const DescribedJoint& joint : robot.joints)
    if (joint.child == link) return &joint;
  return nullptr;
}

bool turns(const DescribedJoint& joint) { return joint.type != JointType::prismatic; }
bool is_out_of_range(const DescribedJoint& joint, double coordinate) {
  return joint.limits && (coordinate < joint.limits->front() || coordinate > joint.limits->back());
}

void check_names(const RobotDescription& robot) {
  const auto fail = [&robot](int line, const std::string& key, const std::string& what) {
    throw common::InputError({.file = robot.file, .line = line, .key = key, .what = what});
  };
  if (robot.links.empty()) throw common::InputError(robot.file, "the robot has no links");
  std::set<std::string> links, joints, children;
  for (const DescribedLink& link : robot.links)
    if (!links.insert(link.name).second) fail(link.line, link.name, "a second link of this name");
  for (const DescribedJoint& joint : robot.joints) {
    if (!joints.insert(joint.name).second)
      fail(joint.line, joint.name, "a second joint of this name");
    for (const std::string& link : {joint.parent, joint.child})
      if (!links.contains(link))
        fail(joint.line, joint.name, fmt::format("there is no link '{}'", link));
    if (!children.insert(joint.child).second)
      fail(joint.line, joint.name,
           fmt::format("the link '{}' is the child of two joints", joint.child));
  }
}

DescribedChain find_chain(const RobotDescription& robot, const std::string& base,
                          const std::string& tip) {
  std::vector<std::string> roots;
  for (const DescribedLink& link : robot.links)
    if (carrier_of(robot, link.name) == nullptr) roots.push_back(link.name);
  DescribedChain chain;
  chain.base = base.empty() ? only_one(robot, roots, "root link", "--base") : base;
  chain.tip = tip.empty() ? usual_tip(robot) : tip;
  require_link(robot, chain.base);
  require_link(robot, chain.tip);
  std::string link = chain.tip;
  while (link != chain.base) {
    const DescribedJoint* joint = carrier_of(robot, link);
    if (joint == nullptr || chain.joints.size() > robot.joints.size())
      throw common::InputError(
          robot.file, fmt::format("no joints lead from '{}' to '{}'", chain.base, chain.tip),
          "Name links of one branch with --base and --tip");
    chain.joints.push_back(static_cast<std::size_t>(joint - robot.joints.data()));
    link = joint->parent;
  }
  std::reverse(chain.joints.begin(), chain.joints.end());
  return chain;
}

}  // namespace kinetostat::vjm
