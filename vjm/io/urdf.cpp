#include "kinetostat/vjm/io/urdf.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <tinyxml2.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"
#include "kinetostat/io/largest_number.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"

namespace kinetostat::vjm {
namespace {

using spatial::Pose;
using spatial::Vector3;
using tinyxml2::XMLElement;

// Elements and attributes with their places.
class UrdfReader {
 public:
  explicit UrdfReader(const std::filesystem::path& file) : file_(file) {}

  UrdfModel read() {
    tinyxml2::XMLDocument document;
    parse(document);
    const XMLElement* robot = document.FirstChildElement("robot");
    if (robot == nullptr)
      throw common::InputError(file_, "there is no <robot> element", "Give a URDF file");
    refuse_xacro(*robot);
    UrdfModel model{.file = file_, .name = text_of(*robot, "name"), .links = {}, .joints = {}};
    for (const XMLElement* e = robot->FirstChildElement("link"); e != nullptr;
         e = e->NextSiblingElement("link"))
      model.links.push_back(read_link(*e));
    for (const XMLElement* e = robot->FirstChildElement("joint"); e != nullptr;
         e = e->NextSiblingElement("joint"))
      model.joints.push_back(read_joint(*e));
    check_names(model);
    return model;
  }

 private:
  [[noreturn]] void fail(const XMLElement& element, const std::string& what,
                         const std::string& cure = {}) const {
    throw common::InputError({.file = file_,
                              .line = element.GetLineNum(),
                              .key = fmt::format("<{}>", element.Name()),
                              .what = what,
                              .cure = cure});
  }

  void parse(tinyxml2::XMLDocument& document) const {
    const std::string text = io::read_text(file_);
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
      throw common::InputError({.file = file_,
                                .line = document.ErrorLineNum(),
                                .what = fmt::format("this is not XML ({})", document.ErrorName())});
  }

  void refuse_xacro(const XMLElement& robot) const {
    for (const XMLElement* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
      if (std::string_view(e->Name()).starts_with("xacro:"))
        fail(*e, "this is a xacro file with macros in it",
             "Expand it first: xacro robot.xacro > robot.urdf");
  }

  std::string text_of(const XMLElement& element, const char* attribute) const {
    const char* value = element.Attribute(attribute);
    if (value == nullptr || *value == '\0')
      fail(element, fmt::format("the attribute '{}' is missing", attribute));
    return value;
  }

  // Exactly `count` finite numbers, with blanks between.
  template <std::size_t count>
  std::array<double, count> numbers(const XMLElement& element, const char* attribute) const {
    const std::string text = text_of(element, attribute);
    std::array<double, count> values{};
    std::size_t found = 0;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (true) {
      while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
      if (at == end) break;
      if (*at == '+') ++at;
      double value = 0;
      const auto [after, error] = std::from_chars(at, end, value);
      if (error != std::errc() || !(std::abs(value) <= io::largest_number) || found == count)
        refuse_numbers(element, attribute, text, count);
      values[found++] = value;
      at = after;
    }
    if (found != count) refuse_numbers(element, attribute, text, count);
    return values;
  }

  [[noreturn]] void refuse_numbers(const XMLElement& element, const char* attribute,
                                   const std::string& text, std::size_t count) const {
    fail(element, fmt::format("{}=\"{}\" is not {} finite number{}", attribute, text, count,
                              count == 1 ? "" : "s"));
  }

  double number(const XMLElement& element, const char* attribute) const {
    return numbers<1>(element, attribute)[0];
  }
  double number_or(const XMLElement& element, const char* attribute, double otherwise) const {
    return element.Attribute(attribute) == nullptr ? otherwise : number(element, attribute);
  }
  Vector3 vector_or(const XMLElement* element, const char* attribute,
                    const Vector3& otherwise) const {
    if (element == nullptr || element->Attribute(attribute) == nullptr) return otherwise;
    const auto v = numbers<3>(*element, attribute);
    return {v[0], v[1], v[2]};
  }

  Pose read_origin(const XMLElement& parent) const {
    const XMLElement* origin = parent.FirstChildElement("origin");
    return {spatial::rotation_from_rpy(vector_or(origin, "rpy", Vector3::Zero())),
            vector_or(origin, "xyz", Vector3::Zero())};
  }

  UrdfInertia read_inertia(const XMLElement& element) const {
    UrdfInertia inertia;
    const XMLElement* mass = element.FirstChildElement("mass");
    if (mass == nullptr) fail(element, "there is no <mass>");
    inertia.mass = number(*mass, "value");
    if (inertia.mass < 0) fail(*mass, "a mass cannot be negative");
    inertia.center = read_origin(element).position();
    if (const XMLElement* moments = element.FirstChildElement("inertia")) {
      static constexpr const char* names[] = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
      for (std::size_t i = 0; i < 6; ++i) inertia.moments[i] = number_or(*moments, names[i], 0);
    }
    return inertia;
  }

  UrdfLink read_link(const XMLElement& element) const {
    UrdfLink link{.name = text_of(element, "name"), .line = element.GetLineNum()};
    if (const XMLElement* inertial = element.FirstChildElement("inertial"))
      link.inertia = read_inertia(*inertial);
    for (const char* kind : {"visual", "collision"})
      for (const XMLElement* e = element.FirstChildElement(kind); e != nullptr;
           e = e->NextSiblingElement(kind)) {
        const XMLElement* geometry = e->FirstChildElement("geometry");
        const XMLElement* mesh =
            geometry == nullptr ? nullptr : geometry->FirstChildElement("mesh");
        if (mesh == nullptr) continue;
        const std::string file = text_of(*mesh, "filename");
        if (std::find(link.meshes.begin(), link.meshes.end(), file) == link.meshes.end())
          link.meshes.push_back(file);
      }
    return link;
  }

  UrdfJointType read_type(const XMLElement& element) const {
    const std::string type = text_of(element, "type");
    if (type == "fixed") return UrdfJointType::fixed;
    if (type == "revolute") return UrdfJointType::revolute;
    if (type == "continuous") return UrdfJointType::continuous;
    if (type == "prismatic") return UrdfJointType::prismatic;
    if (type == "floating" || type == "planar")
      fail(element, fmt::format("a {} joint cannot be part of a stiffness model", type),
           "Cut it out, or replace it by joints with one axis each");
    const std::string near =
        common::nearest_spelling(type, {"fixed", "revolute", "continuous", "prismatic"});
    fail(element, fmt::format("the joint type '{}' is not known", type),
         near.empty() ? "" : fmt::format("Did you mean '{}'?", near));
  }

  std::string linked(const XMLElement& joint, const char* end) const {
    const XMLElement* element = joint.FirstChildElement(end);
    if (element == nullptr) fail(joint, fmt::format("there is no <{}>", end));
    return text_of(*element, "link");
  }

  UrdfJoint read_joint(const XMLElement& element) const {
    UrdfJoint joint{.name = text_of(element, "name"),
                    .line = element.GetLineNum(),
                    .type = read_type(element),
                    .parent = linked(element, "parent"),
                    .child = linked(element, "child")};
    joint.origin = read_origin(element);
    if (joint.type == UrdfJointType::fixed) return joint;
    if (const XMLElement* axis = element.FirstChildElement("axis")) {
      const Vector3 given = vector_or(axis, "xyz", Vector3::UnitX());
      if (!(given.norm() > 1e-9)) fail(*axis, "the axis has no length");
      joint.axis = given.normalized();
    }
    const XMLElement* limit = element.FirstChildElement("limit");
    if (limit != nullptr && joint.type != UrdfJointType::continuous) {
      joint.limits = {number_or(*limit, "lower", 0), number_or(*limit, "upper", 0)};
      if ((*joint.limits)[0] > (*joint.limits)[1]) fail(*limit, "lower is above upper");
    }
    if (const XMLElement* mimic = element.FirstChildElement("mimic")) {
      joint.mimics = text_of(*mimic, "joint");
      joint.mimic_factor = number_or(*mimic, "multiplier", 1);
      joint.mimic_offset = number_or(*mimic, "offset", 0);
    }
    return joint;
  }

  [[noreturn]] void fail_at(int line, const std::string& key, const std::string& what) const {
    throw common::InputError({.file = file_, .line = line, .key = key, .what = what});
  }

  void check_names(const UrdfModel& model) const {
    if (model.links.empty()) throw common::InputError(file_, "the robot has no links");
    std::set<std::string> links, joints, children;
    for (const UrdfLink& link : model.links)
      if (!links.insert(link.name).second)
        fail_at(link.line, link.name, "a second link of this name");
    for (const UrdfJoint& joint : model.joints) {
      if (!joints.insert(joint.name).second)
        fail_at(joint.line, joint.name, "a second joint of this name");
      for (const std::string& link : {joint.parent, joint.child})
        if (!links.contains(link))
          fail_at(joint.line, joint.name, fmt::format("there is no link '{}'", link));
      if (!children.insert(joint.child).second)
        fail_at(joint.line, joint.name,
                fmt::format("the link '{}' is the child of two joints", joint.child));
    }
  }

  const std::filesystem::path& file_;
};

std::vector<std::string> link_names(const UrdfModel& model) {
  std::vector<std::string> names;
  for (const UrdfLink& link : model.links) names.push_back(link.name);
  return names;
}

// The joint that carries a link, if any.
const UrdfJoint* carrier_of(const UrdfModel& model, const std::string& link) {
  for (const UrdfJoint& joint : model.joints)
    if (joint.child == link) return &joint;
  return nullptr;
}

void require_link(const UrdfModel& model, const std::string& link) {
  const std::vector<std::string> names = link_names(model);
  if (std::find(names.begin(), names.end(), link) != names.end()) return;
  const std::string near = common::nearest_spelling(link, names);
  throw common::InputError(model.file, fmt::format("there is no link '{}'", link),
                           near.empty() ? fmt::format("Links are {}", fmt::join(names, ", "))
                                        : fmt::format("Did you mean '{}'?", near));
}

std::string only_one(const UrdfModel& model, const std::vector<std::string>& found,
                     const char* what, const char* option) {
  if (found.size() == 1) return found[0];
  throw common::InputError(
      model.file,
      found.empty() ? fmt::format("there is no {}: the joints form a loop", what)
                    : fmt::format("there are several {}s: {}", what, fmt::join(found, ", ")),
      fmt::format("Name one with {}", option));
}

}  // namespace

UrdfModel read_urdf(const std::filesystem::path& file) { return UrdfReader(file).read(); }

UrdfChain find_chain(const UrdfModel& model, const std::string& base, const std::string& tip) {
  std::vector<std::string> roots, leaves;
  for (const UrdfLink& link : model.links) {
    if (carrier_of(model, link.name) == nullptr) roots.push_back(link.name);
    if (std::none_of(model.joints.begin(), model.joints.end(),
                     [&](const UrdfJoint& joint) { return joint.parent == link.name; }))
      leaves.push_back(link.name);
  }
  UrdfChain chain;
  chain.base = base.empty() ? only_one(model, roots, "root link", "--base") : base;
  chain.tip = tip.empty() ? only_one(model, leaves, "last link", "--tip") : tip;
  require_link(model, chain.base);
  require_link(model, chain.tip);
  std::string link = chain.tip;
  while (link != chain.base) {
    const UrdfJoint* joint = carrier_of(model, link);
    if (joint == nullptr || chain.joints.size() > model.joints.size())
      throw common::InputError(
          model.file, fmt::format("no joints lead from '{}' to '{}'", chain.base, chain.tip),
          "Name links of one branch with --base and --tip");
    chain.joints.push_back(static_cast<std::size_t>(joint - model.joints.data()));
    link = joint->parent;
  }
  std::reverse(chain.joints.begin(), chain.joints.end());
  return chain;
}

}  // namespace kinetostat::vjm
