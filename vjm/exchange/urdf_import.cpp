#include "kinetostat/vjm/exchange/urdf_import.h"

#include <algorithm>
#include <tinyxml2.h>

#include <fmt/format.h>

#include "kinetostat/spatial/rotation.h"
#include "kinetostat/vjm/exchange/xml_file.h"

namespace kinetostat::vjm::urdf_import {
namespace {

using spatial::Matrix3;
using spatial::Pose;
using spatial::Vector3;
using Element = XmlFile::Element;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : xml_(file) {}

  RobotDescription read() {
    const Element& robot = xml_.root("robot", "URDF");
    refuse_xacro(robot);
    RobotDescription description{
        .file = xml_.file(), .format = "URDF", .name = xml_.text(robot, "name")};
    for (const Element* e : XmlFile::children(robot, "link"))
      description.links.push_back(read_link(*e));
    for (const Element* e : XmlFile::children(robot, "joint"))
      description.joints.push_back(read_joint(*e));
    for (const Element* e : XmlFile::children(robot, "gazebo")) read_spring(*e, description);
    check_names(description);
    description.remarks = remarks_;
    return description;
  }

 private:
  void refuse_xacro(const Element& robot) const {
    for (const Element* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
      if (std::string_view(e->Name()).starts_with("xacro:"))
        xml_.fail(*e, "this is a xacro file with macros in it",
                  "Expand it first: xacro robot.xacro > robot.urdf");
  }

  Pose read_origin(const Element& parent) const {
    const Element* origin = XmlFile::child(parent, "origin");
    return {spatial::rotation_from_rpy(xml_.vector_or(origin, "rpy", Vector3::Zero())),
            xml_.vector_or(origin, "xyz", Vector3::Zero())};
  }

  DescribedInertia read_inertia(const Element& element) const {
    DescribedInertia inertia;
    const Element* mass = XmlFile::child(element, "mass");
    if (mass == nullptr) xml_.fail(element, "there is no <mass>");
    inertia.mass = xml_.not_negative(*mass, "value", "a mass");
    const Pose origin = read_origin(element);
    inertia.center = origin.position();
    if (const Element* moments = XmlFile::child(element, "inertia")) {
      const auto about = [&](const char* name) {
        return xml_.not_negative(*moments, name, "a moment of inertia");
      };
      const auto of = [&](const char* name) { return xml_.number_or(*moments, name, 0); };
      Matrix3 tensor;
      tensor << about("ixx"), of("ixy"), of("ixz"), of("ixy"), about("iyy"), of("iyz"), of("ixz"),
          of("iyz"), about("izz");
      inertia.tensor = origin.rotation() * tensor * origin.rotation().transpose();
    }
    return inertia;
  }

  DescribedLink read_link(const Element& element) {
    DescribedLink link{.name = xml_.text(element, "name"), .line = element.GetLineNum()};
    if (const Element* inertial = XmlFile::child(element, "inertial"))
      link.inertia = read_inertia(*inertial);
    for (const char* kind : {"visual", "collision"})
      for (const Element* e : XmlFile::children(element, kind)) {
        const Element* geometry = XmlFile::child(*e, "geometry");
        if (geometry == nullptr) continue;
        DescribedShape shape = read_shape(*geometry, link.name);
        if (shape.is_empty()) continue;
        shape.pose = read_origin(*e);
        shape.is_collision = std::string_view(kind) == "collision";
        link.shapes.push_back(std::move(shape));
      }
    return link;
  }

  DescribedShape read_shape(const Element& geometry, const std::string& link) {
    using Kind = PrimitiveSolid::Kind;
    if (const Element* mesh = XmlFile::child(geometry, "mesh"))
      return {.file = xml_.text(*mesh, "filename"),
              .scale = xml_.vector_or(mesh, "scale", Vector3::Ones())};
    if (const Element* box = XmlFile::child(geometry, "box"))
      return {.solid = {.kind = Kind::box, .edges = xml_.vector(*box, "size")}};
    if (const Element* ball = XmlFile::child(geometry, "sphere"))
      return {.solid = {.kind = Kind::capsule,
                        .radius = xml_.not_negative(*ball, "radius", "a radius")}};
    for (const auto& [name, kind] :
         {std::pair("cylinder", Kind::cylinder), std::pair("capsule", Kind::capsule)})
      if (const Element* e = XmlFile::child(geometry, name))
        return {.solid = {.kind = kind,
                          .radius = xml_.not_negative(*e, "radius", "a radius"),
                          .length = xml_.not_negative(*e, "length", "a length")}};
    if (const Element* other = geometry.FirstChildElement())
      remarks_.push_back(
          fmt::format("Left out: a shape of '{}', for URDF knows no <{}>.", link, other->Name()));
    return {};
  }

  JointType read_type(const Element& element) const {
    const std::string type = xml_.text(element, "type");
    if (type == "fixed") return JointType::fixed;
    if (type == "revolute") return JointType::revolute;
    if (type == "continuous") return JointType::continuous;
    if (type == "prismatic") return JointType::prismatic;
    if (type == "floating" || type == "planar")
      xml_.fail(element, fmt::format("a {} joint cannot be part of a stiffness model", type),
                "Cut it out, or replace it by joints with one axis each");
    xml_.fail_unknown(element, fmt::format("of '{}' the joint type", xml_.text(element, "name")),
                      type, {"fixed", "revolute", "continuous", "prismatic"});
  }

  std::string linked(const Element& joint, const char* end) const {
    const Element* element = XmlFile::child(joint, end);
    if (element == nullptr) xml_.fail(joint, fmt::format("there is no <{}>", end));
    return xml_.text(*element, "link");
  }

  DescribedJoint read_joint(const Element& element) const {
    DescribedJoint joint{.name = xml_.text(element, "name"),
                         .line = element.GetLineNum(),
                         .type = read_type(element),
                         .parent = linked(element, "parent"),
                         .child = linked(element, "child")};
    joint.origin = read_origin(element);
    if (joint.type == JointType::fixed) return joint;
    if (const Element* axis = XmlFile::child(element, "axis"); axis && xml_.has(*axis, "xyz"))
      joint.axis = xml_.direction(*axis, "xyz");
    if (const Element* limit = XmlFile::child(element, "limit")) read_limits(*limit, joint);
    if (const Element* mimic = XmlFile::child(element, "mimic")) {
      joint.mimics = xml_.text(*mimic, "joint");
      joint.mimic_factor = xml_.number_or(*mimic, "multiplier", 1);
      joint.mimic_offset = xml_.number_or(*mimic, "offset", 0);
    }
    return joint;
  }

  void read_limits(const Element& limit, DescribedJoint& joint) const {
    if (xml_.has(limit, "effort")) joint.effort = xml_.not_negative(limit, "effort", "an effort");
    if (joint.type == JointType::continuous) return;
    joint.limits = {xml_.number_or(limit, "lower", 0), xml_.number_or(limit, "upper", 0)};
    if ((*joint.limits)[0] > (*joint.limits)[1]) xml_.fail(limit, "lower is above upper");
  }

  // <gazebo reference="joint"><springStiffness>, as sdformat's reader of URDF takes it.
  void read_spring(const Element& element, RobotDescription& description) const {
    const Element* stiffness = XmlFile::child(element, "springStiffness");
    if (stiffness == nullptr) return;
    const Element* rest = XmlFile::child(element, "springReference");
    const std::string name = xml_.text_or(element, "reference", "");
    for (DescribedJoint& joint : description.joints) {
      if (joint.name != name) continue;
      joint.stiffness = xml_.not_negative(*stiffness, nullptr, "a stiffness");
      joint.rest = rest == nullptr ? 0 : xml_.number(*rest, nullptr);
    }
  }

  XmlFile xml_;
  std::vector<std::string> remarks_;
};

}  // namespace
}  // namespace kinetostat::vjm::urdf_import

namespace kinetostat::vjm {

RobotDescription read_urdf(const std::filesystem::path& file) {
  return urdf_import::Reader(file).read();
}

}  // namespace kinetostat::vjm
